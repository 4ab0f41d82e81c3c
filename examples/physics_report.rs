//! The physics report: runs every check of the physics, compares what was measured with what was expected, and draws plots. The cases are those of
//! `sinew_report`'s tests.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread::{self, available_parallelism};
use std::time::Instant;

use clap::Parser;
use sinew_report::plots::plots;
use sinew_report::{CHAPTERS, Case, Row, cases, json, table};

/// Runs every check of the physics and prints expected and measured values. Exits with 1 if one is out of tolerance.
#[derive(Parser)]
struct Arguments {
    /// Also writes the rows as JSON: an array with one object each.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// The folder for the plots: energy, spin, flips, catenary.
    #[arg(long, value_name = "DIR", default_value = "target/physics_report")]
    plots: PathBuf,
    /// Only cases whose number or title contains this; draws no plots.
    #[arg(long, value_name = "TEXT")]
    only: Option<String>,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let rows = judge(arguments.only.as_deref());
    let wrong = rows.iter().filter(|row| !row.verdict()).count();
    println!("{} of {} rows are within tolerance.", rows.len() - wrong, rows.len());
    if let Err(error) = write(&arguments, &rows) {
        eprintln!("{error}");
        return ExitCode::FAILURE;
    }
    if rows.is_empty() {
        eprintln!("No case has this text in its number or title.");
    }
    if wrong == 0 && !rows.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// Runs the cases, one at a time on each core, and prints a table for each chapter.
fn judge(only: Option<&str>) -> Vec<Row> {
    let is_wanted = |case: &&'static Case| {
        only.is_none_or(|text| case.id == text || case.title().contains(&text.to_lowercase()))
    };
    let wanted: Vec<_> = cases().filter(is_wanted).collect();
    let mut measured = measure(&wanted).into_iter();
    let mut all = Vec::new();
    for chapter in CHAPTERS {
        let count = chapter.cases().filter(is_wanted).count();
        let rows: Vec<_> = measured.by_ref().take(count).flatten().collect();
        if !rows.is_empty() {
            println!("\n{}\n\n{}", chapter.title, table(&rows));
        }
        all.extend(rows);
    }
    all
}

/// The rows of each case, in the order of the cases, whichever finishes first. The last cases, contacts, take longest and are started first, so that no core
/// idles at the end.
fn measure(cases: &[&Case]) -> Vec<Vec<Row>> {
    let (start, next) = (Instant::now(), AtomicUsize::new(0));
    let work = || {
        let mut mine = Vec::new();
        loop {
            let taken = next.fetch_add(1, Ordering::Relaxed) + 1;
            let Some(n) = cases.len().checked_sub(taken) else { return mine };
            mine.push((n, cases[n].rows()));
            let (seconds, count) = (start.elapsed().as_secs_f32(), cases.len());
            eprintln!("{seconds:5.1} s  {taken:3}/{count}  {}: {}", cases[n].id, cases[n].title());
        }
    };
    let cores = available_parallelism().map_or(1, usize::from);
    let mut rows: Vec<_> = thread::scope(|scope| {
        let workers: Vec<_> = (0..cores).map(|_| scope.spawn(work)).collect();
        workers.into_iter().flat_map(|worker| worker.join().expect("no case panics")).collect()
    });
    rows.sort_by_key(|(n, _)| *n);
    rows.into_iter().map(|(_, rows)| rows).collect()
}

/// Writes the files that the arguments name.
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
