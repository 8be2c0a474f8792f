//! The command line: one file for each command's options.

mod bake;
mod check;
mod clock;
mod compare;
mod console;
mod figures;
mod merge;
mod model;
mod open;
mod png;
mod reference;
mod render;
mod spheres;
mod trade;
mod values;
mod view;

pub(crate) use self::bake::BakeArgs;
pub(crate) use self::check::CheckArgs;
pub(crate) use self::clock::ClockArgs;
pub(crate) use self::compare::CompareArgs;
pub(crate) use self::console::ConsoleArgs;
pub(crate) use self::figures::{Figure, FiguresArgs};
pub(crate) use self::merge::MergeArgs;
pub(crate) use self::open::OpenArgs;
pub(crate) use self::png::PngArgs;
pub(crate) use self::reference::{Geometry, ReferenceArgs};
pub(crate) use self::render::{Device, Method, RenderArgs, Visibility};
pub(crate) use self::spheres::SpheresArgs;
pub(crate) use self::trade::{TradeArgs, TradeDevice, TradeGeometry};
pub(crate) use self::view::ViewArgs;

use crate::console::say;
use crate::failure::Failure;
use clap::builder::ValueParser;
use clap::{Arg, CommandFactory, FromArgMatches, Parser, Subcommand, ValueEnum};

/// Soft shadows and glossy light from area lights, without noise.
///
/// Reflectance, light and visibility are sums of cosine lobes, integrated in closed form. Without a FILE commands use a
/// built-in scene.
#[derive(Debug, Parser)]
#[command(name = "lobes", version, after_help = EXAMPLES)]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
}

const EXAMPLES: &str = "Examples:
  lobes render                                         the built-in scene, to lobes.png
  lobes render scene.toml -o picture.png -o linear.exr
  lobes view scene.toml                                a window: drag lights, see their shadows follow
  lobes reference scene.toml -o ref.exr --spp 4096     the same by Monte Carlo
  lobes compare linear.exr ref.exr                     how far the one is from the other";

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    Render(RenderArgs),
    View(OpenArgs),
    Reference(ReferenceArgs),
    Compare(CompareArgs),
    Check(CheckArgs),
    Merge(MergeArgs),
    Bake(BakeArgs),
    Spheres(SpheresArgs),
    Trade(TradeArgs),
    Figures(FiguresArgs),
}

/// The name of a choice, as it is typed.
pub(crate) fn name(value: &impl ValueEnum) -> String {
    value.to_possible_value().map(|v| v.get_name().to_owned()).unwrap_or_default()
}

/// The definition. Values that are no file names may begin with a minus, so that the option itself refuses a
/// negative number and lists the values that it takes.
fn definition() -> clap::Command {
    let named =
        |arg: &Arg| arg.is_positional() || arg.get_value_parser().type_id() == ValueParser::path_buf().type_id();
    let free =
        |arg: Arg| if named(&arg) || !arg.get_action().takes_values() { arg } else { arg.allow_hyphen_values(true) };
    Cli::command().mut_subcommands(|command| command.mut_args(free))
}

/// The requested command; `None` when help or the version was requested and has been printed.
pub(crate) fn parse() -> Result<Option<Command>, Failure> {
    match definition().try_get_matches().and_then(|matches| Cli::from_arg_matches(&matches)) {
        Ok(Cli { command: Some(command) }) => Ok(Some(command)),
        Ok(Cli { command: None }) => {
            say(definition().render_help());
            Ok(None)
        }
        Err(error) if !error.use_stderr() => {
            say(error.render().to_string().trim_end());
            Ok(None)
        }
        Err(error) => {
            // The message and its list end at the first empty line; tips and usage follow.
            let text = error.render().to_string();
            let message = text.split("\n\n").next().unwrap_or_default().trim_start_matches("error: ");
            // The help of the command that was begun.
            let known = |word: &String| definition().get_subcommands().any(|c| c.get_name() == word.as_str());
            let command = std::env::args().nth(1).filter(known).map(|c| format!(" {c}")).unwrap_or_default();
            Err(Failure::new(format_args!("{}; see lobes{command} --help", message.trim_end())))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_definition_is_consistent() {
        definition().debug_assert();
    }
}
