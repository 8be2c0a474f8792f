//! Tables in Markdown.

/// A table; `sound` while all rows are within their stated limits.
pub(crate) struct Table {
    pub(crate) sound: bool,
}

impl Table {
    pub(crate) fn head(what: &str, columns: &[&str]) {
        println!("\n## {what}\n\n| {} | value | f64 | error |", columns.join(" | "));
        println!("|{}", "---|".repeat(columns.len() + 3));
    }

    /// A row: the error is relative to `scale`, which is the value itself or a scale named in the documentation.
    pub(crate) fn row(&mut self, words: &[String], got: f32, want: f64, scale: f64, limit: f64) {
        let error = if want == f64::from(got) { 0.0 } else { (f64::from(got) - want).abs() / scale };
        let bad = if error <= limit { "" } else { " **beyond what is stated**" };
        self.sound &= bad.is_empty();
        // Without the sign of a zero.
        println!("| {} | {:.6e} | {want:.6e} | {error:.1e}{bad} |", words.join(" | "), got + 0.0);
    }
}
