use super::*;
use cosine_lobes::read_exr;

#[test]
fn bad_pictures_are_refused() {
    let folder = folder();
    let folder = folder.path();
    picture(folder, "a.exr", 2, &[1.0; 4]);
    picture(folder, "wide.exr", 4, &[1.0; 4]);
    picture(folder, "nan.exr", 2, &[1.0, f32::NAN, 1.0, 1.0]);
    fs::write(folder.join("noise.exr"), b"this is no picture").unwrap();
    fs::write(folder.join("empty.exr"), b"").unwrap();
    let bytes = fs::read(folder.join("a.exr")).unwrap();
    fs::write(folder.join("cut.exr"), &bytes[..bytes.len() / 2]).unwrap();
    refuse(folder, &["compare", "a.exr", "wide.exr"], "sizes differ");
    refuse(folder, &["compare", "a.exr", "a.exr", "--unshadowed", "wide.exr"], "sizes differ");
    for bad in ["noise.exr", "empty.exr", "cut.exr", "nan.exr", "missing.exr", "scene.toml", "."] {
        refuse(folder, &["compare", "a.exr", bad], bad);
        refuse(folder, &["compare", bad, "a.exr"], bad);
        refuse(folder, &["compare", "a.exr", "a.exr", "--unshadowed", bad], bad);
    }
    refuse(folder, &["compare", "a.exr", "a.exr", "--diff", "no/diff.png"], "no/diff.png");
    // Any single damaged byte gives a picture or an error, never a panic.
    for i in (0..bytes.len()).step_by(7) {
        let mut damaged = bytes.clone();
        damaged[i] ^= 0x55;
        fs::write(folder.join("damaged.exr"), &damaged).unwrap();
        let _ = read_exr(&folder.join("damaged.exr"));
    }
}

#[test]
fn comparing_follows_the_contract() {
    let folder = folder();
    let folder = folder.path();
    picture(folder, "a.exr", 2, &[1.0, 0.75, 0.0, 1.0]);
    picture(folder, "b.exr", 2, &[1.0, 0.50, 0.0, 1.0]);
    picture(folder, "u.exr", 2, &[1.0, 1.00, 1.0, 1.0]);
    let keys = ["mae", "rmse", "max", "mean_relative", "bias", "flip", "reference_mean", "pixels"];
    let plain = json(folder, &["compare", "a.exr", "b.exr", "--json"]);
    assert!(keys.iter().all(|k| plain[*k].is_number()), "{plain}");
    assert!(plain.get("penumbra").is_none());
    assert_eq!((plain["mae"].as_f64(), plain["bias"].as_f64()), (Some(0.0625), Some(0.0625)));
    let args =
        ["compare", "a.exr", "b.exr", "--json", "--unshadowed", "u.exr", "--diff", "d.png", "--heatmap", "h.png"];
    let penumbra = &json(folder, &args)["penumbra"];
    assert_eq!(penumbra["pixels"], 1);
    assert!(["mean", "p99", "max"].iter().all(|k| (penumbra[*k].as_f64().unwrap() - 0.25).abs() < 1e-9), "{penumbra}");
    assert!(fs::read(folder.join("d.png")).unwrap().starts_with(b"\x89PNG"));
    assert!(fs::read(folder.join("h.png")).unwrap().starts_with(b"\x89PNG"));
}

#[test]
fn a_png_is_refused_with_what_to_do() {
    let folder = folder();
    let folder = folder.path();
    fs::write(folder.join("a.png"), "").unwrap();
    refuse(folder, &["compare", "a.png", "a.png"], "OpenEXR is needed (render -o picture.exr)");
}
