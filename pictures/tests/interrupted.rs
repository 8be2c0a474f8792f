//! Ctrl-C at any moment: alone in its program, because its effect is permanent.

use pictures::{Output, remove_unfinished};
use std::fs;
use std::io::Write;
use std::sync::Barrier;

/// Threads write one file after another while the handler runs: every remaining file has its name and is whole.
#[test]
fn nothing_is_left_by_work_that_goes_on() {
    let folder = tempfile::tempdir().expect("a folder");
    let start = Barrier::new(5);
    let refused: Vec<String> = std::thread::scope(|scope| {
        let writers: Vec<_> = (0..4)
            .map(|thread| {
                let (folder, start) = (folder.path(), &start);
                scope.spawn(move || {
                    start.wait();
                    (0..10_000).find_map(|k| {
                        let path = folder.join(format!("{thread}.{k}.exr"));
                        let written = Output::create(path).and_then(|output| {
                            output.finish(|file| {
                                file.write_all(b"whole").expect("written");
                                Ok(())
                            })
                        });
                        written.err().map(|error| error.to_string())
                    })
                })
            })
            .collect();
        start.wait();
        while fs::read_dir(folder.path()).expect("readable").count() < 20 {}
        remove_unfinished();
        writers.into_iter().filter_map(|w| w.join().expect("no panic")).collect()
    });
    assert_eq!(refused.len(), 4, "{refused:?}");
    for entry in fs::read_dir(folder.path()).expect("readable").flatten() {
        let name = entry.file_name().into_string().expect("a name");
        assert!(name.ends_with(".exr") && fs::read(entry.path()).expect("readable") == b"whole", "{name}");
    }
    assert!(Output::create(folder.path().join("late.exr")).is_err());
}
