//! Writes the JavaScript that a browser needs beside a WebAssembly module that was built with wasm-bindgen:
//! `cosine-lobes-web-glue MODULE FOLDER NAME` makes `FOLDER/NAME.js` and `FOLDER/NAME_bg.wasm`.

use std::env::args;
use std::process::ExitCode;
use wasm_bindgen_cli_support::Bindgen;

fn main() -> ExitCode {
    let [module, folder, name] = match <[String; 3]>::try_from(args().skip(1).collect::<Vec<_>>()) {
        Ok(given) => given,
        Err(_) => {
            eprintln!("cosine-lobes-web-glue MODULE FOLDER NAME");
            return ExitCode::from(2);
        }
    };
    let mut tool = Bindgen::new();
    tool.input_path(module).out_name(&name).typescript(false);
    tool.remove_name_section(true).remove_producers_section(true);
    let made = tool.web(true).and_then(|tool| tool.generate(folder));
    match made {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error:#}");
            ExitCode::FAILURE
        }
    }
}
