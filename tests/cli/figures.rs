use super::*;

#[test]
fn figures_are_drawn_and_kept() {
    let folder = folder();
    let folder = folder.path();
    let said = succeed(folder, &["figures", "2", "-o", "out/deep"]);
    assert!(said.contains("Fig. 2 ") && said.contains("figures.md"), "{said}");
    let out = folder.join("out/deep");
    assert_eq!(names(&out), ["fig02.png", "fig02.svg", "figures.md"]);
    let gallery = fs::read_to_string(out.join("figures.md")).unwrap();
    // The integral at three exponents.
    for exponent in [0.1, 1.0] {
        let integral = format!("{:.3} at", std::f64::consts::TAU / (exponent + 1.0));
        assert!(gallery.contains(&integral) || gallery.contains(&integral.replace(" at", " at e")), "{gallery}");
    }
    for part in ["## Fig. 2: ", "(fig02.png)", "(fig02.svg)", "**Shows.**", "**The paper.**", "**Here.**"] {
        assert!(gallery.contains(part), "{part}: {gallery}");
    }
    let image = image::open(out.join("fig02.png")).unwrap();
    assert!(image.width() > 300 && image.to_luma8().pixels().any(|p| p.0[0] < 100), "something is drawn");
    assert!(fs::read_to_string(out.join("fig02.svg")).unwrap().contains("exponent"));

    // A picture, on top of the curve, which stays; the same command makes the same files.
    succeed(folder, &["figures", "21", "21", "-o", "out/deep", "--quiet", "--threads", "2"]);
    let all = ["fig02.png", "fig02.svg", "fig21.png", "figures.md"];
    assert_eq!(names(&out), all);
    let read = || all.map(|name| fs::read(out.join(name)).unwrap());
    let first = read();
    let gallery = String::from_utf8(first[3].clone()).unwrap();
    let titles: Vec<&str> =
        gallery.lines().filter(|l| l.starts_with("## ")).filter_map(|l| l.split(':').next()).collect();
    assert_eq!(titles, ["## Fig. 2", "## Fig. 21"]);
    assert_eq!(succeed(folder, &["figures", "21", "2", "-o", "out/deep", "--quiet", "--threads", "1"]), "");
    assert!(read() == first);
}

#[test]
fn figures_that_are_not_there_are_refused() {
    let folder = folder();
    let folder = folder.path();
    // There is no number in the paper's Fig. 1 and 7: they are drawings of the idea.
    for name in ["1", "7", "23", "Fig.2", "table2", ""] {
        refuse(folder, &["figures", "2", name, "-o", "out"], "table1");
    }
    refuse(folder, &["figures", "2"], "--output");
    refuse(folder, &["figures", "2", "-o", "scene.toml"], "scene.toml");
    refuse(folder, &["figures", "2", "-o", "out", "--threads", "0"], "--threads");
    // The list is in the help.
    let help = succeed(folder, &["figures", "--help"]);
    for part in ["- 2: ", "- 13: ", "- table1: ", "figures.md", "Examples:"] {
        assert!(help.contains(part), "{part}: {help}");
    }
}
