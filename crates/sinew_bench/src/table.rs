//! The results as text, as Markdown, and as JSON.

use crate::row::{Row, Stretch, Unit};

/// Column headings.
const HEADS: [&str; 13] = [
    "",
    "scene",
    "unit",
    "ours",
    "naive",
    "rapier",
    "Avian",
    "naive/ours",
    "rapier/ours",
    "stretch, ours",
    "naive",
    "rapier",
    "Avian",
];

/// The rows as a table with aligned columns; the notes are below it. A stretch is "mean / largest", per cent.
pub fn table(rows: &[Row]) -> String {
    let mut lines = vec![HEADS.map(String::from)];
    lines.extend(rows.iter().map(cells));
    let width = |column: usize| lines.iter().map(|l| l[column].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..HEADS.len()).map(width).collect();
    let mut page = String::new();
    for line in &lines {
        let mut out = String::new();
        for (column, (cell, &width)) in line.iter().zip(&widths).enumerate() {
            let room = " ".repeat(width - cell.chars().count());
            // Text is left-aligned, numbers are right-aligned.
            let cell = if column < 3 { format!("{cell}{room}") } else { format!("{room}{cell}") };
            out += &cell;
            out += "  ";
        }
        page += out.trim_end();
        page.push('\n');
    }
    for row in rows.iter().filter(|row| !row.note.is_empty()) {
        page += &format!("{:4} {}: {}\n", row.id, row.scene, row.note);
    }
    page
}

/// The rows as a Markdown table, with their settings, without empty columns.
pub fn markdown(rows: &[Row]) -> String {
    let heads = HEADS.map(|head| if head.is_empty() { "#" } else { head });
    let heads = heads.into_iter().chain(["substeps × sweeps", "note"]);
    let mut lines: Vec<Vec<String>> = vec![heads.map(String::from).collect()];
    lines.extend(rows.iter().map(|row| {
        let swept = format!("{} × {}", row.substeps, row.sweeps);
        let settings = if row.substeps == 0 { String::new() } else { swept };
        cells(row).into_iter().chain([settings, row.note.clone()]).collect()
    }));
    let used =
        |column: &usize| lines[1..].iter().any(|line| !matches!(line[*column].as_str(), "" | "–"));
    let columns: Vec<usize> = (0..lines[0].len()).filter(used).collect();
    let mut page = String::new();
    for (number, line) in lines.iter().enumerate() {
        let cells: Vec<&str> = columns.iter().map(|&column| line[column].as_str()).collect();
        page += &format!("| {} |\n", cells.join(" | "));
        if number == 0 {
            page += &format!("|{}\n", "---|".repeat(columns.len()));
        }
    }
    page
}

/// The rows as a JSON array of objects. A missing figure is `null`, and so are the `…_ns` of figures that are not times.
pub fn json(rows: &[Row]) -> String {
    let objects: Vec<String> = rows.iter().map(object).collect();
    format!("[\n{}\n]\n", objects.join(",\n"))
}

fn cells(row: &Row) -> [String; 13] {
    let (scale, unit) = shown(row);
    let figure = |x: Option<f64>| x.map_or("–".into(), |x| number(x * scale));
    let times = |x: Option<f64>| x.map_or("–".into(), |x| format!("{}×", number(x)));
    [
        row.id.into(),
        row.scene.clone(),
        unit.into(),
        figure(row.ours),
        figure(row.naive),
        figure(row.peer),
        figure(row.avian),
        times(row.ratio()),
        times(row.peer_ratio()),
        stretched(row.stretch),
        stretched(row.naive_stretch),
        stretched(row.peer_stretch),
        stretched(row.avian_stretch),
    ]
}

/// Factor and unit for display.
fn shown(row: &Row) -> (f64, &'static str) {
    let most = [row.ours, row.naive, row.peer, row.avian].into_iter().flatten().fold(0.0, f64::max);
    match row.unit {
        Unit::Tick if most >= 1e5 => (1e-6, "ms/tick"),
        Unit::Tick => (1e-3, "µs/tick"),
        Unit::WallTick => (1e-6, "ms/tick (wall)"),
        Unit::Once if most >= 1e5 => (1e-6, "ms"),
        Unit::Once => (1e-3, "µs"),
        unit => (1.0, unit.name()),
    }
}

fn stretched(stretch: Option<Stretch>) -> String {
    let percent = |x: f64| if x.is_finite() { number(100.0 * x) } else { "∞".into() };
    stretch.map_or(String::new(), |s| format!("{} / {} %", percent(s.mean), percent(s.max)))
}

/// Three significant digits; smaller and larger numbers in exponent notation.
fn number(x: f64) -> String {
    let size = x.abs();
    match size {
        _ if !x.is_finite() => "∞".into(),
        0.0 => "0".into(),
        _ if size >= 1e6 => format!("{x:.1e}"),
        _ if size >= 99.95 => format!("{x:.0}"),
        _ if size >= 9.995 => format!("{x:.1}"),
        _ if size >= 0.0995 => format!("{x:.2}"),
        _ => format!("{x:.1e}"),
    }
}

fn object(row: &Row) -> String {
    let ns = |x: Option<f64>| numeral(x.filter(|_| row.unit.is_time()));
    let part = |s: Option<Stretch>, of: fn(Stretch) -> f64| numeral(s.map(of));
    let (mean, max) = (|s: Stretch| s.mean, |s: Stretch| s.max);
    let fields: Vec<String> = [
        ("id", quoted(row.id)),
        ("scene", quoted(&row.scene)),
        ("unit", quoted(row.unit.name())),
        ("constraints", row.constraints.to_string()),
        ("substeps", row.substeps.to_string()),
        ("sweeps", row.sweeps.to_string()),
        ("ours_ns", ns(row.ours)),
        ("naive_ns", ns(row.naive)),
        ("peer_ns", ns(row.peer)),
        ("avian_ns", ns(row.avian)),
        ("ours", numeral(row.ours)),
        ("naive", numeral(row.naive)),
        ("peer", numeral(row.peer)),
        ("ratio", numeral(row.ratio())),
        ("peer_ratio", numeral(row.peer_ratio())),
        ("mean_stretch", part(row.stretch, mean)),
        ("max_stretch", part(row.stretch, max)),
        ("naive_mean_stretch", part(row.naive_stretch, mean)),
        ("naive_max_stretch", part(row.naive_stretch, max)),
        ("peer_mean_stretch", part(row.peer_stretch, mean)),
        ("peer_max_stretch", part(row.peer_stretch, max)),
        ("avian_mean_stretch", part(row.avian_stretch, mean)),
        ("avian_max_stretch", part(row.avian_stretch, max)),
        ("note", quoted(&row.note)),
    ]
    .map(|(name, value)| format!("\"{name}\": {value}"))
    .into();
    format!("  {{{}}}", fields.join(", "))
}

/// A number as JSON, which has no infinity.
fn numeral(x: Option<f64>) -> String {
    x.filter(|x| x.is_finite()).map_or("null".into(), |x| format!("{x:.6e}"))
}

fn quoted(text: &str) -> String {
    let mut out = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => out.extend(['\\', c]),
            c if c < ' ' => out += &format!("\\u{:04x}", u32::from(c)),
            c => out.push(c),
        }
    }
    out.push('"');
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row() -> Row {
        let stretch = Some(Stretch { mean: 0.0081, max: f64::INFINITY });
        let (ours, naive) = (Some(2.0), Some(20.0));
        Row { ours, naive, stretch, ..Row::new("P1", "a \"cloth\"", Unit::Projection) }
    }

    #[test]
    fn a_row_is_read_by_people_and_by_programs() {
        let page = table(&[row()]);
        assert!(page.contains("10.0×") && page.contains("0.81 / ∞ %"), "{page}");
        let text = json(&[row(), row()]);
        assert!(text.contains(r#""scene": "a \"cloth\"""#), "{text}");
        assert!(text.contains(r#""ours_ns": 2.000000e0"#) && text.contains(r#""peer_ns": null"#));
        assert!(text.contains(r#""max_stretch": null"#) && text.contains(r#""ratio": 1.000000e1"#));
    }

    #[test]
    fn a_document_gets_the_columns_in_which_something_stands_and_the_settings() {
        let rows = [row().sized(7, 10, 4), Row { naive: None, ..row().noted("it rests") }];
        let page = markdown(&rows);
        let lines: Vec<_> = page.lines().collect();
        let heads = "| # | scene | unit | ours | naive | naive/ours | stretch, ours | substeps × sweeps | note |";
        assert_eq!(lines[0], heads);
        assert_eq!(lines[1], "|---|---|---|---|---|---|---|---|---|");
        let first =
            "| P1 | a \"cloth\" | ns/projection | 2.00 | 20.0 | 10.0× | 0.81 / ∞ % | 10 × 4 |  |";
        assert_eq!(lines[2], first);
        assert!(lines[3].ends_with("| – | – | 0.81 / ∞ % |  | it rests |"), "{page}");
        assert_eq!(lines.len(), 4);
    }

    #[test]
    fn what_is_no_time_has_no_nanoseconds() {
        let text = json(&[Row { unit: Unit::Allocations, ..row() }]);
        assert!(text.contains(r#""ours_ns": null"#) && text.contains(r#""ours": 2.0"#), "{text}");
    }
}
