//! The report as text, and as JSON.

use crate::{Allowed, Row};

/// The rows as a table with aligned columns, one line a row: id, what, expected, measured, error, allowed, verdict (✓ or ✗).
pub fn table(rows: &[Row]) -> String {
    let mut lines =
        vec![["", "what", "expected", "measured", "error", "allowed", ""].map(String::from)];
    lines.extend(rows.iter().map(cells));
    let width = |column: usize| lines.iter().map(|l| l[column].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..7).map(width).collect();
    let mut page = String::new();
    for line in &lines {
        let mut out = String::new();
        for (column, (cell, &width)) in line.iter().zip(&widths).enumerate() {
            let room = " ".repeat(width - cell.chars().count());
            // Text is left-aligned, numbers are right-aligned.
            let cell = if column < 2 { format!("{cell}{room}") } else { format!("{room}{cell}") };
            out += &cell;
            out += "  ";
        }
        page += out.trim_end();
        page.push('\n');
    }
    page
}

fn cells(row: &Row) -> [String; 7] {
    let unit = if row.unit.is_empty() { String::new() } else { format!(" {}", row.unit) };
    let expected = match row.allowed {
        Allowed::AtMost => format!("≤ {}", number(row.expected)),
        Allowed::AtLeast => format!("≥ {}", number(row.expected)),
        _ => number(row.expected),
    };
    let (error, allowed) = match row.allowed {
        Allowed::Relative(most) => (share(row.error(), most), format!("± {}", share(most, most))),
        Allowed::Absolute(0.0) => (small(row.error()), "exactly".into()),
        Allowed::Absolute(most) => (small(row.error()), format!("± {}", small(most))),
        Allowed::AtMost | Allowed::AtLeast => (small(row.error()), "limit".into()),
    };
    let verdict = if row.verdict() { "✓" } else { "✗" };
    let measured = format!("{}{unit}", number(row.measured));
    [
        row.id.into(),
        row.what.clone(),
        format!("{expected}{unit}"),
        measured,
        error,
        allowed,
        verdict.into(),
    ]
}

/// Six significant digits without trailing zeros.
fn number(x: f64) -> String {
    if x == 0.0 || !x.is_finite() {
        return format!("{}", x + 0.0);
    }
    let size = libm::floor(libm::log10(x.abs())) as i32;
    if (-4..6).contains(&size) {
        let digits = (5 - size).clamp(0, 9) as usize;
        let text = format!("{x:.digits$}");
        if text.contains('.') {
            text.trim_end_matches('0').trim_end_matches('.').into()
        } else {
            text
        }
    } else {
        format!("{x:.3e}")
    }
}

/// An error in a unit: two significant digits.
fn small(x: f64) -> String {
    if x == 0.0 { "0".into() } else { format!("{x:.1e}") }
}

/// A relative error as per cent, or as a power of ten if the tolerance is less than 0.01 %.
fn share(x: f64, most: f64) -> String {
    if most < 1e-4 {
        small(x)
    } else if x.abs() < 5e-6 {
        "0.000 %".into()
    } else {
        format!("{:.3} %", x * 100.0)
    }
}

/// The rows as JSON: an array with one object a row, each on a line. `error`, `expected` and `measured` are `null` if they are not finite.
pub fn json(rows: &[Row]) -> String {
    let objects: Vec<String> = rows.iter().map(object).collect();
    format!("[\n{}\n]\n", objects.join(",\n"))
}

fn object(row: &Row) -> String {
    let (kind, amount) = match row.allowed {
        Allowed::Relative(most) => ("relative", most),
        Allowed::Absolute(most) => ("absolute", most),
        Allowed::AtMost => ("at most", 0.0),
        Allowed::AtLeast => ("at least", 0.0),
    };
    format!(
        "  {{\"id\": {}, \"what\": {}, \"unit\": {}, \"expected\": {}, \"measured\": {}, \"error\": {}, \"allowed\": {{\"kind\": {}, \"amount\": {}}}, \"verdict\": {}}}",
        quoted(row.id),
        quoted(&row.what),
        quoted(row.unit),
        numeral(row.expected),
        numeral(row.measured),
        numeral(row.error()),
        quoted(kind),
        numeral(amount),
        row.verdict(),
    )
}

/// The shortest decimal that parses to the same number; JSON has no NaN and no infinity.
fn numeral(x: f64) -> String {
    if x.is_finite() { format!("{x:?}") } else { "null".into() }
}

/// A JSON string: quotes, backslashes and control characters escaped.
fn quoted(text: &str) -> String {
    let mut out = String::from('"');
    for c in text.chars() {
        match c {
            '"' | '\\' => {
                out.push('\\');
                out.push(c);
            }
            c if c < ' ' => out += &format!("\\u{:04x}", c as u32),
            c => out.push(c),
        }
    }
    out.push('"');
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows() -> Vec<Row> {
        vec![
            Row::relative("a parabola", "m", -11.62, -11.6201, 1e-5),
            Row::absolute("said \"so\"\\\n", "", 0.0, f64::NAN, 0.5),
            Row::at_most("stretch", "%", 0.21, 0.2),
        ]
    }

    #[test]
    fn columns_are_aligned_whatever_is_in_them() {
        let rows: Vec<Row> = rows().into_iter().filter(|row| !row.what.contains('\n')).collect();
        let page = table(&rows);
        let lines: Vec<Vec<char>> = page.lines().map(|line| line.chars().collect()).collect();
        assert_eq!(lines.len(), 3);
        assert!(lines[1].ends_with(&['✓']) && lines[1].len() == lines[2].len());
        assert!(page.contains("-11.6201 m") && page.contains("≤ 0.21 %"));
    }

    #[test]
    fn json_escapes_what_it_must_and_has_no_nan() {
        let text = json(&rows());
        assert!(text.contains(r#""what": "said \"so\"\\\u000a""#), "{text}");
        assert!(text.contains(r#""measured": null"#) && !text.contains("NaN"), "{text}");
        assert_eq!(text.matches("\"verdict\": ").count(), 3);
        assert!(text.starts_with("[\n  {") && text.ends_with("}\n]\n"));
    }

    #[test]
    fn numbers_keep_six_digits() {
        for (x, text) in [
            (0.0, "0"),
            (-0.0, "0"),
            (12.0, "12"),
            (0.502_612_3, "0.502612"),
            (3.1e-7, "3.100e-7"),
            (123_456.7, "123457"),
            (f64::NAN, "NaN"),
        ] {
            assert_eq!(number(x), text);
        }
    }
}
