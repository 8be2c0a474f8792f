//! The paper's figures and its table, redone: each is drawn and measured by one function, and put into a gallery.
//!
//! Curves and diagrams are drawn once, on any backend, and written as SVG and PNG; figures made of pictures are PNG only. The
//! gallery's sentences about the paper quote it; all other numbers come from the run.

mod bars;
mod canvas;
mod chart;
mod gallery;
mod integrals;
mod lab;
mod lobe_sums;
mod masks;
mod measure;
mod products;
mod renders;
mod scenes;
mod sets;
mod studio;
mod times;

use self::gallery::Page;
use self::studio::Studio;
use crate::args::{Figure, FiguresArgs};
use crate::console::{self, say};
use crate::failure::Failure;
use clap::ValueEnum;
use std::time::Instant;

pub(crate) fn run(args: &FiguresArgs) -> Result<(), Failure> {
    console::set_threads(args.threads)?;
    let failed = |e: std::io::Error| Failure::new(format_args!("{}: {e}", args.output.display()));
    std::fs::create_dir_all(&args.output).map_err(failed)?;
    let mut figures = match args.figures.is_empty() {
        true => Figure::value_variants().to_vec(),
        false => args.figures.clone(),
    };
    figures.sort();
    figures.dedup();
    let index = args.output.join("figures.md");
    let mut studio = Studio::new(args.quiet);
    for figure in figures {
        let start = Instant::now();
        let page = page(figure, &mut studio)?;
        for image in &page.images {
            image.write(&args.output)?;
        }
        // Sections of earlier runs stay; the file is replaced whole.
        let old = std::fs::read_to_string(&index).unwrap_or_default();
        let text = gallery::with_section(&old, figure, &gallery::section(figure, &page));
        canvas::write_text(&index, &text)?;
        if !args.quiet {
            let seconds = start.elapsed().as_secs_f64();
            say(format_args!("{:8} {} ({seconds:.1} s)", gallery::label(figure), page.title));
        }
    }
    if !args.quiet {
        say(index.display());
    }
    Ok(())
}

fn page(figure: Figure, studio: &mut Studio) -> Result<Page, Failure> {
    let name = gallery::stem(figure);
    match figure {
        Figure::F2 => integrals::of_one_lobe(&name),
        Figure::F3 => products::error(&name, studio),
        Figure::F4 => integrals::of_products(&name),
        Figure::F5 => renders::thresholds(&name, studio),
        Figure::F6 => products::exponent(&name, studio),
        Figure::F8 => masks::square(&name, studio),
        Figure::F9 => masks::tree(&name, studio),
        Figure::F10 => masks::lobes(&name, studio),
        Figure::F11 => masks::overlap(&name, studio),
        Figure::F12 => renders::methods_beside_reference(&name, studio),
        Figure::F13 => renders::lafortune(&name, studio),
        Figure::F14 => lobe_sums::integration(&name, studio),
        Figure::F15 => lobe_sums::savings(&name, studio),
        Figure::F16 => renders::many(&name, studio),
        Figure::F17 => times::by_area(&name, studio),
        Figure::F18 => renders::self_shadows(&name, studio),
        Figure::F19 => renders::square_light(&name, studio),
        Figure::F20 => times::by_lights(&name, studio),
        Figure::F21 => renders::several_lights(&name),
        Figure::F22 => renders::softening(&name, studio),
        Figure::Table1 => times::by_stage(&name, studio),
    }
}
