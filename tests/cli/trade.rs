use super::*;

const SWEEP: [&str; 14] = [
    "trade",
    "scene.toml",
    "-o",
    "out",
    "--method",
    "moments",
    "--tolerance",
    "0.03,0.003",
    "--depth",
    "3,5",
    "--reference-spp",
    "1024",
    "--repeat",
    "3",
];

fn sweep(folder: &Path, further: &[&str]) -> Vec<Value> {
    let rows = json(folder, &[&SWEEP[..], further, &["--json"]].concat());
    rows.as_array().unwrap().clone()
}

#[test]
fn trade_measures_and_goes_on() {
    let folder = folder();
    let folder = folder.path();
    let first = sweep(folder, &["--spp", "4"]);
    // Spheres and rays, two tolerances and two depths each; the sampler culled and not.
    assert_eq!(first.len(), 2 * 4 + 2);
    assert_eq!(
        names(&folder.join("out")),
        [
            "reference.checkpoint",
            "reference.exr",
            "sheet.png",
            "trade.csv",
            "trade.json",
            "trade.md",
            "trade.png",
            "trade.svg"
        ]
    );
    for row in &first {
        for key in ["seconds", "spread", "frame_seconds", "mean", "p99", "flip"] {
            assert!(row[key].as_f64().is_some_and(|x| x >= 0.0), "{key} in {row}");
        }
        assert_eq!((&row["scene"], &row["device"]), (&"scene".into(), &"cpu".into()));
        assert!(row["frame_seconds"].as_f64() > row["seconds"].as_f64(), "{row}");
    }
    let mean = |method: &str, depth: u64| {
        let row = first.iter().find(|r| r["method"] == method && (depth == 0 || r["depth"] == depth));
        row.unwrap()["mean"].as_f64().unwrap()
    };
    // Within the requested error (0.26 % and 0.04 % measured, the reference's own 0.05 % included); four samples are not (12 %).
    assert!(mean("moments", 3) < 0.01 && mean("moments", 5) < 0.002 && mean("samples", 0) > 0.01);
    assert!(first.iter().any(|r| r["front"] == true) && first.iter().any(|r| r["front"] == false));

    // A row that is gone is measured again, the others are kept as they are; so are those of another sweep.
    let path = folder.join("out/trade.json");
    let all: Value = serde_json::from_str(&fs::read_to_string(&path).unwrap()).unwrap();
    let kept: Vec<Value> = all.as_array().unwrap()[1..].to_vec();
    fs::write(&path, serde_json::to_string(&kept).unwrap()).unwrap();
    let again = sweep(folder, &["--spp", "4,16"]);
    assert_eq!(again.len(), first.len() + 2);
    for (old, new) in kept.iter().zip(&again) {
        assert_eq!((&old["seconds"], &old["mean"]), (&new["seconds"], &new["mean"]));
    }
    let text = fs::read_to_string(folder.join("out/trade.csv")).unwrap();
    assert_eq!(text.lines().count(), again.len() + 1);

    // Another scene: nothing is kept.
    fs::write(folder.join("scene.toml"), SCENE.replace("radius = 0.6 }", "radius = 0.5 }")).unwrap();
    let other = sweep(folder, &["--spp", "4"]);
    assert_eq!(other.len(), first.len());
    assert!(other.iter().all(|r| r["stamp"] != first[0]["stamp"]));
}

#[test]
fn trade_compares_like_with_like() {
    let folder = folder();
    let folder = folder.path();
    fs::write(folder.join("table.toml"), format!("{SCENE}{TABLE}")).unwrap();
    refuse(folder, &["trade", "table.toml", "-o", "out", "--visibility", "rays"], "--geometry spheres");
    refuse(folder, &["trade", "table.toml", "-o", "out", "--visibility", "scene"], "--visibility scene");
    refuse(folder, &["trade", "scene.toml", "-o", "scene.toml"], "scene.toml");
    refuse(folder, &["trade", "--size", "9000x9000", "-o", "out"], "too many");
    refuse(folder, &["trade", "--spp", "0", "-o", "out"], "--spp");
    refuse(folder, &["trade"], "--output");
    let rows = json(
        folder,
        &[
            "trade",
            "table.toml",
            "-o",
            "out",
            "--geometry",
            "mesh",
            "--size",
            "24x16",
            "--tolerance",
            "0.01",
            "--depth",
            "4",
            "--spp",
            "4",
            "--reference-spp",
            "64",
            "--repeat",
            "3",
            "--method",
            "moments",
            "--json",
        ],
    );
    let words: Vec<&str> = rows.as_array().unwrap().iter().map(|r| r["visibility"].as_str().unwrap()).collect();
    assert_eq!(words, ["scene", "spheres", "shadow-map", "silhouettes", "rays", "rays", "rays"]);
}

/// Ctrl-C between two rows keeps those that are finished, whole; the same command measures the others.
#[cfg(unix)]
#[test]
fn trade_can_be_interrupted() {
    let folder = folder();
    let folder = folder.path();
    // Many repetitions: the first row is long there when the last one begins.
    let args = ["--spp", "4", "--visibility", "spheres", "--quiet"];
    let long: Vec<&str> = SWEEP.iter().chain(&args).map(|a| if *a == "3" { "1000" } else { a }).collect();
    let mut command = Command::new(env!("CARGO_BIN_EXE_lobes"));
    let mut child = command.current_dir(folder).args(&long).stderr(std::process::Stdio::null()).spawn().unwrap();
    let table = folder.join("out/trade.json");
    while !table.exists() {
        assert!(child.try_wait().unwrap().is_none(), "ended before its first row");
        std::thread::sleep(std::time::Duration::from_millis(10));
    }
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert_eq!(names(&folder.join("out")), ["reference.checkpoint", "reference.exr", "trade.json"]);
    let rows: Vec<Value> = serde_json::from_str(&fs::read_to_string(table).unwrap()).unwrap();
    assert!((1..6).contains(&rows.len()), "{}", rows.len());
}

/// Killed between two rows, within a row or while the table is written: finished rows are kept to the bit, damaged ones are not.
#[cfg(unix)]
#[test]
fn trade_survives_being_killed() {
    let folder = folder();
    let folder = folder.path();
    let table = folder.join("out/trade.json");
    let args = ["--spp", "4", "--visibility", "spheres", "--quiet", "--json"];
    let long: Vec<&str> = SWEEP.iter().chain(&args).map(|a| if *a == "3" { "400" } else { a }).collect();
    let read = || -> Vec<Value> { serde_json::from_str(&fs::read_to_string(&table).unwrap()).unwrap() };
    let mut rows: Vec<Value> = Vec::new();
    for wait in [0, 37, 120] {
        let mut command = Command::new(env!("CARGO_BIN_EXE_lobes"));
        let mut child = command.current_dir(folder).args(&long).stdout(std::process::Stdio::null()).spawn().unwrap();
        let more = || table.exists() && read().len() > rows.len();
        while !more() && child.try_wait().unwrap().is_none() {
            std::thread::sleep(std::time::Duration::from_millis(5));
        }
        std::thread::sleep(std::time::Duration::from_millis(wait));
        child.kill().unwrap();
        child.wait().unwrap();
        let now = read();
        assert!(now.len() > rows.len());
        for (old, new) in rows.iter().zip(&now) {
            assert_eq!((&old["seconds"], &old["mean"]), (&new["seconds"], &new["mean"]));
        }
        rows = now;
    }
    // A digit of the first row changes: that row is measured anew, and said to be.
    let text = fs::read_to_string(&table).unwrap();
    let changed = text.replacen("\"repeats\": ", "\"repeats\": 1", 1);
    assert_ne!(changed, text);
    fs::write(&table, changed).unwrap();
    let finish: Vec<&str> = long.iter().copied().filter(|a| *a != "--quiet").collect();
    let ran = lobes(folder, &finish);
    let told = String::from_utf8(ran.stderr).unwrap();
    assert!(ran.status.success() && told.contains("trade.json: 1 row damaged"), "{told}");
    let all: Vec<Value> = serde_json::from_slice(&ran.stdout).unwrap();
    assert_eq!(all.len(), 4 + 2);
    for old in &rows[1..] {
        assert!(all.iter().any(|new| (&old["seconds"], &old["mean"]) == (&new["seconds"], &new["mean"])), "{old}");
    }
    assert!(names(&folder.join("out")).iter().all(|n| !n.ends_with(".tmp")), "{:?}", names(&folder.join("out")));
}
