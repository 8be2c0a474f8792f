use super::*;

/// Parts of a picture are to the bit those of the whole: bands, windows that cut tiles, every strategy, every layer.
#[test]
fn parts_make_the_whole_to_the_bit() {
    let folder = folder();
    let folder = folder.path();
    fs::write(folder.join("table.toml"), format!("{SCENE}{TABLE}")).unwrap();
    for visibility in ["spheres", "shadow-map", "silhouettes", "rays"] {
        let render = |output: &str, further: &[&str]| {
            let base = ["render", "table.toml", "--quiet", "--layers", "--visibility", visibility, "-o", output];
            succeed(folder, &[&base[..], further].concat());
        };
        render("whole.exr", &[]);
        let whole = fs::read(folder.join("whole.exr")).unwrap();
        for i in 1..=3 {
            render(&format!("tile{i}.exr"), &["--tiles", &format!("{i}/3")]);
        }
        succeed(folder, &["merge", "tile2.exr", "tile1.exr", "tile3.exr", "-o", "merged.exr", "--quiet"]);
        assert!(fs::read(folder.join("merged.exr")).unwrap() == whole, "{visibility}: tiles");

        for (name, crop) in [("a.exr", "0,0,19,32"), ("b.exr", "19,0,48,5"), ("c.exr", "19,5,48,32")] {
            render(name, &["--crop", crop, "--threads", "1"]);
        }
        succeed(folder, &["merge", "a.exr", "b.exr", "c.exr", "-o", "merged.exr", "-o", "merged.png"]);
        assert!(fs::read(folder.join("merged.exr")).unwrap() == whole, "{visibility}: windows");
        succeed(folder, &["render", "table.toml", "--quiet", "--visibility", visibility, "-o", "whole.png"]);
        assert_eq!(fs::read(folder.join("merged.png")).unwrap(), fs::read(folder.join("whole.png")).unwrap());
    }
}

#[test]
fn parts_that_make_no_picture_are_refused() {
    let folder = folder();
    let folder = folder.path();
    for (name, tiles) in [("a.exr", "1/2"), ("b.exr", "2/2")] {
        succeed(folder, &["render", "scene.toml", "--quiet", "--tiles", tiles, "-o", name]);
    }
    let bigger = ["render", "scene.toml", "--quiet", "--size", "48x40", "--tiles", "2/2", "-o", "other.exr"];
    succeed(folder, &bigger);
    refuse(folder, &["merge", "a.exr", "-o", "m.exr"], "pixels are in no part");
    refuse(folder, &["merge", "a.exr", "a.exr", "-o", "m.exr"], "that an earlier one has");
    refuse(folder, &["merge", "a.exr", "other.exr", "-o", "m.exr"], "other.exr: part 2 is of another picture");
    refuse(folder, &["merge", "a.exr", "scene.toml", "-o", "m.exr"], "scene.toml");
    refuse(folder, &["merge", "a.exr", "b.exr", "-o", "a.exr"], "both read and written");
    refuse(folder, &["merge", "a.exr", "b.exr", "-o", "m.jpg"], ".png or .exr");
    refuse(folder, &["merge", "-o", "m.exr"], "PART");
    for (option, value, what) in [
        ("--tiles", "0/2", "expected I/N"),
        ("--tiles", "1/5", "4 tiles of 8"),
        ("--crop", "0,0,49,32", "only 48 x 32"),
        ("--crop", "9,0,9,32", "expected X0,Y0,X1,Y1"),
    ] {
        refuse(folder, &["render", "scene.toml", "-o", "m.exr", option, value], what);
    }
    refuse(folder, &["render", "scene.toml", "--crop", "0,0,8,8", "--tiles", "1/2"], "--tiles");
}

/// A quality is its tolerance and depth; a budget picks some of the measured front.
#[test]
fn quality_and_time_budget_choose_the_setting() {
    let folder = folder();
    let folder = folder.path();
    let setting = |further: &[&str]| {
        let stats = json(folder, &[&["render", "scene.toml", "-o", "a.png", "--json"][..], further].concat());
        (stats["tolerance"].as_f64().unwrap(), stats["depth"].as_u64().unwrap())
    };
    let (draft, high) = (setting(&["--quality", "draft"]), setting(&["--quality", "high"]));
    assert!(draft.0 > setting(&["--quality", "interactive"]).0 && high.0 < 0.005, "{draft:?} {high:?}");
    let (tolerance, depth) = (high.0.to_string(), high.1.to_string());
    succeed(folder, &["render", "scene.toml", "-o", "b.png", "--tolerance", &tolerance, "--depth", &depth]);
    setting(&["--quality", "high"]);
    assert_eq!(fs::read(folder.join("a.png")).unwrap(), fs::read(folder.join("b.png")).unwrap());
    // Time without end takes the best, none at all the fastest.
    assert_eq!(setting(&["--time-budget", "1e6"]), high);
    assert!(setting(&["--time-budget", "1e-6"]).0 >= draft.0);
    let ran = lobes(folder, &["render", "scene.toml", "-o", "a.png", "--time-budget", "1e-6"]);
    assert!(String::from_utf8(ran.stderr).unwrap().contains("no setting is faster"));
    for other in [["--tolerance", "0.01"], ["--depth", "4"], ["--time-budget", "9"]] {
        refuse(folder, &["render", "scene.toml", "--quality", "draft", other[0], other[1]], "--quality");
    }
    refuse(folder, &["render", "scene.toml", "--time-budget", "9", "--tiles", "1/2"], "--time-budget");
    refuse(folder, &["render", "scene.toml", "--time-budget", "0"], "above 0");
}
