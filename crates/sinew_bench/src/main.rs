//! Runs the scenes of the table of goals and prints the speeds of Sinew, of the naive reference and of other engines side by side.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Parser;
use sinew_bench::measure::Effort;
use sinew_bench::row::Row;
use sinew_bench::scenes::SCENES;
use sinew_bench::{growth, peers, table};

/// Measures the CPU time of Sinew, of a naive reference and of other engines, with the quality beside it.
#[derive(Parser)]
struct Arguments {
    /// Runs only these scenes, separated by commas: P1,P3.
    #[arg(long, value_name = "IDS", value_delimiter = ',')]
    only: Vec<String>,
    /// Also writes the rows as JSON: an array with an object for each.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Also writes the rows as a Markdown table: those of `docs/speed.md` and of the README.
    #[arg(long, value_name = "FILE")]
    markdown: Option<PathBuf>,
    /// Measures how the cost grows from 1k to 4M constraints, and plots it as a PNG.
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
    /// Runs the same scenes in rapier3d; requires the feature `peers`.
    #[arg(long)]
    peers: bool,
    /// Number of timed portions; the median is reported.
    #[arg(long, value_name = "N", default_value_t = 15)]
    rounds: usize,
    /// Runs a tenth of the ticks, to try the program out.
    #[arg(long)]
    quick: bool,
    /// Runs the user scenes with the default threads of an app, and measures wall-clock time; requires the feature `threads`.
    #[arg(long)]
    threads: bool,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    if arguments.peers && !peers::THERE {
        eprintln!("This build has no other engine: add `--features peers`.");
        return ExitCode::FAILURE;
    }
    if arguments.threads && !cfg!(feature = "threads") {
        eprintln!("This build of Bevy is single-threaded: add `--features threads`.");
        return ExitCode::FAILURE;
    }
    let Arguments { rounds, quick, peers, threads, .. } = arguments;
    let effort = Effort { rounds, quick, peers, threads };
    let rows = measure(&arguments, &effort);
    println!("{}", table::table(&rows));
    match write(&arguments, &effort, &rows) {
        Ok(()) if rows.is_empty() && arguments.plot.is_none() => {
            eprintln!("This build has no such scene.");
            ExitCode::FAILURE
        }
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

/// Runs the chosen scenes. For the plot alone choose a scene that does not exist: `--only none`.
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
        println!("wrote {}", path.display());
    }
    Ok(())
}

fn save(path: &Path, text: &str) -> Result<(), String> {
    std::fs::write(path, text).map_err(|error| format!("{}: {error}", path.display()))
}
