//! The index of the folder: a section for each figure.

use super::canvas::Image;
use crate::args::{Figure, name};
use std::fmt::Write;

/// A figure that is done.
pub(super) struct Page {
    /// Its title, a few words.
    pub(super) title: &'static str,
    pub(super) images: Vec<Image>,
    /// The content of the figure.
    pub(super) shows: String,
    /// The paper's statement, with the place.
    pub(super) paper: String,
    /// The result of this program.
    pub(super) here: String,
    /// The differences between the two settings, and the values that the paper leaves open.
    pub(super) differs: String,
}

/// The paper's name for a figure.
pub(super) fn label(figure: Figure) -> String {
    match figure {
        Figure::Table1 => "Table 1".to_owned(),
        figure => format!("Fig. {}", name(&figure)),
    }
}

/// The beginning of its file names.
pub(super) fn stem(figure: Figure) -> String {
    match figure {
        Figure::Table1 => "table1".to_owned(),
        figure => format!("fig{:0>2}", name(&figure)),
    }
}

const HEAD: &str = "# The paper's figures, redone

S. Meunier, R. Perrot, L. Aveneau, D. Meneveaux and D. Ghazanfarpour, *Cosine lobes for interactive direct lighting in dynamic scenes*,
Computers & Graphics 34 (2010) 767–778. `lobes figures -o DIR` makes this page and its pictures. Every number under **Here** is measured by
that command; those under **The paper** are quoted.

*Method `paper`* follows the paper: least-squares lobes, tabulated products, shadow nodes. *Method `moments`* is this project's own: closed
integrals and visible fractions. Both use the same blocker spheres. The paper's models are not available here: Spot the cow (5 856 triangles,
Keenan Crane) stands for them, with spheres fitted to her, as many as in the paper. Times are those of the machine that ran the command; the
paper used an Intel Core i7 920 with an NVIDIA GTX 280. A *pixel-to-pixel difference* is the mean of |A − B|/B over pixels.
Fig. 1 and 7 explain an idea and are left out.
";

/// One section.
pub(super) fn section(figure: Figure, page: &Page) -> String {
    let mut text = format!("## {}: {}\n\n", label(figure), page.title);
    for image in page.images.iter().filter(|i| i.name.ends_with(".png")) {
        let _ = write!(text, "![{}]({})\n\n", page.title, image.name);
    }
    for image in page.images.iter().filter(|i| i.name.ends_with(".svg")) {
        let _ = write!(text, "[The same as SVG]({})\n\n", image.name);
    }
    for (word, what) in
        [("Shows", &page.shows), ("The paper", &page.paper), ("Here", &page.here), ("Differs", &page.differs)]
    {
        if !what.is_empty() {
            let _ = write!(text, "**{word}.** {what}\n\n");
        }
    }
    text
}

/// The index with a section put in its place; the other sections of `old` stay.
pub(super) fn with_section(old: &str, figure: Figure, section: &str) -> String {
    use clap::ValueEnum;
    let mut kept: Vec<(Figure, String)> = Vec::new();
    for part in old.split("\n## ").skip(1) {
        let title = part.split(':').next().unwrap_or_default();
        if let Some(of) = Figure::value_variants().iter().find(|f| label(**f) == title && **f != figure) {
            kept.push((*of, format!("## {}\n\n", part.trim_end())));
        }
    }
    kept.push((figure, section.to_owned()));
    kept.sort_by_key(|(figure, _)| *figure);
    let mut text = HEAD.to_owned();
    kept.iter().for_each(|(_, section)| {
        text.push('\n');
        text.push_str(section.trim_end());
        text.push('\n');
    });
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sections_are_replaced_and_sorted() {
        let text = with_section("", Figure::F12, "## Fig. 12: a\n\nold\n");
        let text = with_section(&text, Figure::Table1, "## Table 1: c\n\n| a |\n");
        let text = with_section(&text, Figure::F2, "## Fig. 2: b\n\nnew\n");
        let text = with_section(&text, Figure::F12, "## Fig. 12: a\n\nnew\n");
        let titles: Vec<&str> = text.lines().filter(|l| l.starts_with("## ")).collect();
        assert_eq!(titles, ["## Fig. 2: b", "## Fig. 12: a", "## Table 1: c"]);
        assert!(text.starts_with(HEAD) && !text.contains("old") && text.contains("| a |"));
        // The same section once more changes nothing.
        assert_eq!(with_section(&text, Figure::F2, "## Fig. 2: b\n\nnew\n"), text);
    }
}
