//! The page of results: every check of the physics, run, measured and judged, with pictures. The cases are those of `sinew_report`'s tests.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use clap::Parser;
use sinew_report::plots::plots;
use sinew_report::{CHAPTERS, Row, cases, json, table};

/// Runs every check of the physics and prints what was expected and what was measured; a wrong verdict exits with 1.
#[derive(Parser)]
struct Arguments {
    /// Writes the rows as JSON, too: an array with an object for each.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// The folder for the pictures: energy, spin, flips, catenary.
    #[arg(long, value_name = "DIR", default_value = "target/physics_report")]
    plots: PathBuf,
    /// Only cases whose number or title contains this; no pictures then.
    #[arg(long, value_name = "TEXT")]
    only: Option<String>,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let rows = judge(arguments.only.as_deref());
    let wrong = rows.iter().filter(|row| !row.verdict()).count();
    println!("{} of {} rows are within what is allowed.", rows.len() - wrong, rows.len());
    if let Err(error) = write(&arguments, &rows) {
        eprintln!("{error}");
        return ExitCode::FAILURE;
    }
    if rows.is_empty() {
        eprintln!("No case has that in its number or its title.");
    }
    if wrong == 0 && !rows.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// Runs the cases and prints a table for each chapter, as soon as it is complete.
fn judge(only: Option<&str>) -> Vec<Row> {
    let wanted = |id: &str, title: &str| {
        only.is_none_or(|text| id == text || title.contains(&text.to_lowercase()))
    };
    let (total, mut done, mut all) = (cases().count(), 0, Vec::new());
    let start = Instant::now();
    for chapter in CHAPTERS {
        let mut rows = Vec::new();
        for case in chapter.cases() {
            done += 1;
            if wanted(case.id, &case.title()) {
                let seconds = start.elapsed().as_secs_f32();
                eprintln!("{seconds:5.1} s  {done:3}/{total}  {}: {}", case.id, case.title());
                rows.extend(case.rows());
            }
        }
        if !rows.is_empty() {
            println!("\n{}\n\n{}", chapter.title, table(&rows));
        }
        all.extend(rows);
    }
    all
}

/// Writes what was asked for beside the table.
fn write(arguments: &Arguments, rows: &[Row]) -> Result<(), String> {
    if let Some(file) = &arguments.json {
        make_folder(file.parent())?;
        std::fs::write(file, json(rows)).map_err(|error| format!("{}: {error}", file.display()))?;
        println!("{}", file.display());
    }
    if arguments.only.is_none() {
        for plot in plots() {
            println!("{}", plot.write(&arguments.plots)?.display());
        }
    }
    Ok(())
}

fn make_folder(folder: Option<&Path>) -> Result<(), String> {
    match folder {
        Some(folder) if folder != Path::new("") => std::fs::create_dir_all(folder)
            .map_err(|error| format!("{}: {error}", folder.display())),
        _ => Ok(()),
    }
}
