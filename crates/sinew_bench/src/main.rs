//! The page of speeds: runs the scenes of the table of goals and prints, beside each other, Sinew, the naive way and a rival.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Parser;
use sinew_bench::measure::Effort;
use sinew_bench::row::Row;
use sinew_bench::scenes::SCENES;
use sinew_bench::{growth, peers, table};

/// Measures how fast Sinew is, next to the naive way and to a rival, in CPU time, with the quality beside it.
#[derive(Parser)]
struct Arguments {
    /// Only these scenes, with commas between them: P1,P3.
    #[arg(long, value_name = "IDS", value_delimiter = ',')]
    only: Vec<String>,
    /// Writes the rows as JSON, too: an array with an object for each.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Writes the rows as a table in Markdown, too: those of `docs/speed.md` and of the README.
    #[arg(long, value_name = "FILE")]
    markdown: Option<PathBuf>,
    /// Measures how the cost grows from 1k to 4M constraints, and draws it as a PNG.
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
    /// Runs the same scenes in rapier3d; needs the feature `peers`.
    #[arg(long)]
    peers: bool,
    /// Portions of which the median is taken.
    #[arg(long, value_name = "N", default_value_t = 15)]
    rounds: usize,
    /// A tenth of the ticks, to try the program out.
    #[arg(long)]
    quick: bool,
    /// Runs the user scenes with the threads that an app has of itself, and times them by the clock at the wall; needs the feature `threads`.
    #[arg(long)]
    threads: bool,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    if arguments.peers && !peers::THERE {
        eprintln!("There is no rival in this build: add `--features peers`.");
        return ExitCode::FAILURE;
    }
    if arguments.threads && !cfg!(feature = "threads") {
        eprintln!("An app has one thread in this build: add `--features threads`.");
        return ExitCode::FAILURE;
    }
    let Arguments { rounds, quick, peers, threads, .. } = arguments;
    let effort = Effort { rounds, quick, peers, threads };
    let rows = measure(&arguments, &effort);
    println!("{}", table::table(&rows));
    match write(&arguments, &effort, &rows) {
        Ok(()) if rows.is_empty() && arguments.plot.is_none() => {
            eprintln!("There is no such scene in this build.");
            ExitCode::FAILURE
        }
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

/// Runs what is wanted. To draw the picture alone, ask for a scene that there is not: `--only none`.
fn measure(arguments: &Arguments, effort: &Effort) -> Vec<Row> {
    let wanted = |id: &str| {
        arguments.only.iter().any(|one| one.eq_ignore_ascii_case(id)) || arguments.only.is_empty()
    };
    let mut rows = Vec::new();
    for scene in SCENES.iter().filter(|scene| wanted(scene.id)) {
        eprintln!("{} ...", scene.id);
        rows.extend((scene.run)(effort));
    }
    rows
}

fn write(arguments: &Arguments, effort: &Effort, rows: &[Row]) -> Result<(), String> {
    if let Some(path) = &arguments.json {
        save(path, &table::json(rows))?;
    }
    if let Some(path) = &arguments.markdown {
        save(path, &table::markdown(rows))?;
    }
    if let Some(path) = &arguments.plot {
        growth::draw(effort, path)?;
        println!("drawn: {}", path.display());
    }
    Ok(())
}

fn save(path: &Path, text: &str) -> Result<(), String> {
    std::fs::write(path, text).map_err(|error| format!("{}: {error}", path.display()))
}
