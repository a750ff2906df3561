//! A grid has the values of its file, and each cell is run once and whole.

use msd_run::Runner;
use msd_scene::FileError;
use msd_study::monitor::{Halt, Monitor, Progress};
use msd_study::sweep::{Column, Datum, Kind, Store, Summary, Sweep, Table, TableFormat};
use std::fs;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

fn folder() -> TempDir {
    tempfile::tempdir().expect("a folder")
}

/// Writes a sweep of the chain and opens it.
fn open(folder: &Path, text: &str) -> Result<Sweep, FileError> {
    let path = folder.join("sweep.toml");
    fs::write(&path, text).expect("a file");
    Sweep::open(&path)
}

const HEAD: &str = "version = 1\nscene = 'chain'\nduration = 0.1\n";

fn chain(folder: &Path, grid: &str) -> Sweep {
    open(folder, &format!("{HEAD}[grid]\n{grid}")).expect("a sweep")
}

/// The refusal, wherever it comes from: opening the file, replacing keys or building the scene.
fn refused(text: &str) -> String {
    let folder = folder();
    let all = open(folder.path(), text).and_then(|sweep| {
        (0..sweep.len()).try_for_each(|number| sweep.load(&sweep.cell(number)?).map(drop))
    });
    let told = all.expect_err(text).to_string();
    assert!(!told.contains('\n'), "{told}");
    told.replace(&format!("{}/", folder.path().display()), "")
}

fn words(sweep: &Sweep) -> Vec<String> {
    let cell = |number| sweep.words(&sweep.cell(number).expect("a cell"));
    (0..sweep.len()).map(cell).collect()
}

fn run(sweep: &Sweep, store: &Store, jobs: usize) -> Summary {
    msd_study::sweep::run(sweep, store, (0..sweep.len(), jobs), &mut ()).expect("a run")
}

/// The summary of a sweep that is done, on the processor.
fn counts(run: usize, skipped: usize, diverged: usize) -> Summary {
    Summary { run, skipped, diverged, ..Summary::default() }
}

fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).expect("a folder").flatten();
    let mut files: Vec<PathBuf> = entries.map(|entry| entry.path()).collect();
    files.sort();
    files
}

/// The columns of a table that do not hold times of computing.
fn timeless(table: &Table) -> Vec<Vec<Datum>> {
    let times = ["cpu_seconds", "cpu_per_second", "wall_seconds", "spring_updates_per_second"];
    let kept = |place: &usize| !times.contains(&table.columns[*place].name.as_str());
    let places: Vec<usize> = (0..table.columns.len()).filter(kept).collect();
    let row = |row: &Vec<Datum>| places.iter().map(|&place| row[place].clone()).collect();
    table.rows.iter().map(row).collect()
}

#[test]
fn the_last_key_of_the_grid_runs_fastest_and_keys_keep_their_order() {
    let folder = folder();
    let grid = "\"solver.substeps\" = [4, 8]\n\"bodies[0].stiffness\" = [10.5, 20]\n";
    let expected = [
        "solver.substeps = 4, bodies[0].stiffness = 10.5",
        "solver.substeps = 4, bodies[0].stiffness = 20",
        "solver.substeps = 8, bodies[0].stiffness = 10.5",
        "solver.substeps = 8, bodies[0].stiffness = 20",
    ];
    assert_eq!(words(&chain(folder.path(), grid)), expected);
    let json = r#"{"version": 1, "scene": "chain", "grid": {"solver.substeps": [4, 8],
        "bodies[0].stiffness": [10.5, 20]}}"#;
    let path = folder.path().join("sweep.json");
    fs::write(&path, json).expect("a file");
    assert_eq!(words(&Sweep::open(&path).expect("a sweep")), expected);
}

#[test]
fn keys_may_stand_in_tables_and_values_may_be_ranges() {
    let folder = folder();
    let grid = "solver.substeps = { from = 1, to = 100, count = 3, scale = 'log' }";
    let expected = ["solver.substeps = 1", "solver.substeps = 10", "solver.substeps = 100"];
    assert_eq!(words(&chain(folder.path(), grid)), expected);
    let turned = chain(folder.path(), "solver.substeps = [1]\nsolver.integrator = ['rk4']");
    assert_eq!(words(&turned), ["solver.substeps = 1, solver.integrator = \"rk4\""]);
    let quoted = grid.replace("solver.substeps", "'solver.substeps'");
    assert_eq!(words(&chain(folder.path(), &quoted)), expected);
}

#[test]
fn a_cell_is_the_scene_with_its_values() {
    let folder = folder();
    let grid = "'world.gravity' = [[0, -1, 0]]\n'solver.precision' = ['f64']\n\
        'bodies[0].stiffness' = [33]\n'solver.integrator' = ['rk4']";
    let sweep = chain(folder.path(), grid);
    let loaded = sweep.load(&sweep.cell(0).expect("a cell")).expect("a scene");
    assert_eq!(loaded.scene.world.gravity.to_array(), [0.0, -1.0, 0.0]);
    assert_eq!(loaded.scene.springs[0].stiffness, 33.0);
    assert_eq!(loaded.settings.integrator.name(), "rk4");
    assert_eq!(loaded.precision.name(), "f64");
    // Keys that the grid does not name stay.
    assert_eq!((loaded.settings.substeps, loaded.scene.springs[0].damping), (4, 1.0));
}

#[test]
fn a_scene_file_and_its_mesh_are_found_beside_the_sweep() {
    let folder = folder();
    let scene = "version = 1\n[[bodies]]\nkind = 'mesh'\nfile = 'thing.obj'\nlength = 1\n";
    fs::write(folder.path().join("scene.toml"), scene).expect("a file");
    let mesh = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";
    fs::write(folder.path().join("thing.obj"), mesh).expect("a file");
    let text = "version = 1\nscene = 'scene.toml'\n[grid]\n'bodies[0].mass' = [1, 2]";
    let sweep = open(folder.path(), text).expect("a sweep");
    let cell = sweep.cell(1).expect("a cell");
    let loaded = sweep.load(&cell).expect("a scene");
    let mass: f64 = loaded.scene.particles.iter().map(|particle| particle.mass).sum();
    assert!((mass - 2.0).abs() < 1e-12);
    // Another mesh in the same file is another cell.
    fs::write(folder.path().join("thing.obj"), mesh.replace("1 0 0", "2 0 0")).expect("a file");
    let other = open(folder.path(), text).expect("a sweep").cell(1).expect("a cell");
    assert_ne!(cell.hash, other.hash);
    let bare = "version = 1\nscene = 'thing.obj'\n[grid]\n'bodies[0].mass' = [1, 2]";
    let sweep = open(folder.path(), bare).expect("a sweep");
    assert!(sweep.load(&sweep.cell(0).expect("a cell")).is_ok());
}

#[test]
fn the_hash_tells_what_matters_and_nothing_else() {
    let folder = folder();
    let hash = |text: &str, number| {
        let sweep = open(folder.path(), text).expect("a sweep");
        sweep.cell(number).expect("a cell").hash
    };
    let one = format!("{HEAD}[grid]\n'solver.substeps' = [4, 8]\n'bodies[0].mass' = [1, 2]");
    let turned = format!("{HEAD}[grid]\n'bodies[0].mass' = [2.0, 3]\n'solver.substeps' = [8]");
    // Substeps 8 and mass 2, in either.
    assert_eq!(hash(&one, 3), hash(&turned, 0));
    assert_eq!(hash(&one, 3).len(), 16);
    let hashes: std::collections::BTreeSet<_> = (0..4).map(|number| hash(&one, number)).collect();
    assert_eq!(hashes.len(), 4);
    for other in [
        one.replace("0.1", "0.2"),
        one.replace("[grid]", "error = true\n[grid]"),
        one.replace("'chain'", "'square'"),
    ] {
        assert_ne!(hash(&one, 3), hash(&other, 3), "{other}");
    }
    let same = one.replace("[grid]", "format = 'csv'\nout = 'elsewhere'\n[grid]");
    assert_eq!(hash(&one, 3), hash(&same, 3));
}

#[test]
fn bad_sweep_files_are_refused_by_place_key_and_domain() {
    let grid = |grid: &str| refused(&format!("{HEAD}[grid]\n{grid}"));
    let list = "it must be a list of values, or a range such as \
        { from = 1, to = 100, count = 3, scale = \"log\" }";
    for (told, expected) in [
        (refused(""), "sweep.toml:1:1: the sweep lacks the key `version`".into()),
        (
            refused("version = 2\nscene = 'chain'"),
            "sweep.toml:1:11: version is 2; it must be 1".into(),
        ),
        (
            refused("version = 1\nscene = 'chain'\nduratoin = 1"),
            "sweep.toml:3:1: unknown key `duratoin` in the sweep; did you mean `duration`?".into(),
        ),
        (
            refused("version = 1\nscene = 'chain'\nduration = -1"),
            "sweep.toml:3:12: duration is -1; it must be positive and finite".into(),
        ),
        (
            refused("version = 1\nscene = 'chain'\nformat = 'xls'"),
            "sweep.toml:3:10: format is \"xls\"; it must be one of csv, parquet".into(),
        ),
        (
            refused("version = 1\nscene = 'chian'\n[grid]\nx = [1]"),
            "sweep.toml:2:9: scene: no scene `chian`: did you mean `chain`?".into(),
        ),
        (
            grid("'solver.substeps' = []"),
            format!("sweep.toml:5:1: grid key solver.substeps is an empty list; {list}"),
        ),
        (
            grid("'solver.substeps' = 4"),
            format!("sweep.toml:5:1: grid key solver.substeps is 4; {list}"),
        ),
        (
            grid("'solver.substeps' = [4, 4]"),
            "sweep.toml:5:25: grid key solver.substeps has the value 4 twice".into(),
        ),
        (
            grid("'world.gravity' = [0, -1, 0]"),
            "sweep.toml:5:27: grid key world.gravity has the value 0 twice; a list of vectors is \
             [[x, y, z], ...]"
                .into(),
        ),
        (
            grid("'solver substeps' = [4]"),
            "sweep.toml:5:1: grid key \"solver substeps\" is not a key of a scene such as \
                \"solver.substeps\" or \"bodies[0].stiffness\""
                .into(),
        ),
    ] {
        assert_eq!(told, expected);
    }
    assert!(grid("").contains("the grid has no cells"));
    assert_eq!(refused(HEAD), "sweep.toml: the sweep lacks the key `grid`");
}

#[test]
fn bad_ranges_are_refused() {
    let range = |range: &str| refused(&format!("{HEAD}[grid]\n'solver.step' = {{ {range} }}"));
    for (text, expected) in [
        ("from = 0, to = 1, count = 3, scale = 'log'", "from is 0; it must be positive where"),
        ("from = 0, to = inf, count = 3", "to is inf; it must be finite"),
        ("from = 0, to = 1, count = 1", "count is 1; it must be a whole number from 2 to 100000"),
        ("from = 0, to = 1", "count is missing; it must be a whole number"),
        ("to = 1, count = 2", "from is missing; it must be a number"),
        ("from = 'a', to = 1, count = 2", "from is \"a\"; it must be a number"),
        ("from = 0, to = 1, count = 2, scale = 'lin'", "it must be \"linear\" or \"log\""),
        ("from = 0, to = 1, cuont = 2", "unknown key `cuont` in the range of grid key solver.step"),
        ("from = 1, to = 1, count = 2", "grid key solver.step has the value 1 twice"),
    ] {
        let told = range(text);
        assert!(told.starts_with("sweep.toml:5:") && told.contains(expected), "{told}");
    }
}

#[test]
fn values_that_the_scene_refuses_are_told_where_the_grid_has_them() {
    let grid = |grid: &str| refused(&format!("{HEAD}[grid]\n{grid}"));
    for (text, expected) in [
        ("'solver.substeps' = [4, -1]", "sweep.toml:5:25: solver.substeps is -1; it must be"),
        ("'solver.substeps' = [0]", "sweep.toml:5:22: solver.substeps is 0; it must be from 1"),
        ("'solver.substeps' = [1.5]", "sweep.toml:5:22: solver.substeps is 1.5; it must be"),
        (
            "'bodies[0].mass' = ['x']",
            "sweep.toml:5:21: bodies[0].mass is \"x\"; it must be a number",
        ),
        ("'world.gravity' = [[0, 1]]", "sweep.toml:5:20: world.gravity is a list of 2; it must"),
        ("'solver.integrator' = ['rk5']", "sweep.toml:5:24: solver.integrator is \"rk5\"; it must"),
        (
            "'solver.substep' = [1]",
            "sweep.toml:5:21: unknown key `substep` in solver; did you mean",
        ),
        ("'solvr.substeps' = [1]", "sweep.toml:5:21: unknown key `solvr` in the scene; did you"),
        ("'bodies[1].mass' = [1]", "sweep.toml:5:21: grid key bodies[1].mass: bodies of the scene"),
        ("'solver.step' = [5]", "sweep.toml:3:12: duration is 0.1 s; it must be at least half a"),
        ("'solver.step' = [1e-12]", "sweep.toml:3:12: duration is 0.1 s; it must be at most 1e10"),
    ] {
        let told = grid(text);
        assert!(told.starts_with(expected), "{told}");
    }
    let both = "'solver.step' = [0.01]\n'solver.steps_per_second' = [60, 30]";
    let told = grid(both);
    assert!(told.contains("cell 0 (solver.step = 0.01, solver.steps_per_second = 60)"), "{told}");
    let met = refused("version = 1\nscene = 'chain'\nerror = true\n[grid]\nsolver.step = [0.0123]");
    assert!(met.contains("no step of 0.0123 s does in cell 0"), "{met}");
}

#[test]
fn too_many_cells_and_keys_that_overlap_are_refused() {
    let hundred = |key| format!("'{key}' = {{ from = 1, to = 100, count = 100 }}\n");
    let keys = ["solver.substeps", "bodies[0].mass", "bodies[0].stiffness"].map(hundred);
    let told = refused(&format!("{HEAD}[grid]\n{}", keys.concat()));
    let expected = "the grid has 100 x 100 x 100 = 1000000 cells; at most 100000 are run as one \
        sweep";
    assert!(told.ends_with(expected), "{told}");
    let told = refused(&format!("{HEAD}[grid]\n'bodies[0]' = [1]\n'bodies[0].mass' = [1]"));
    assert!(told.ends_with("grid keys bodies[0] and bodies[0].mass set the same value"), "{told}");
}

#[cfg(not(feature = "parquet"))]
#[test]
fn a_format_that_was_left_out_is_refused_before_anything_runs() {
    let folder = folder();
    let text = format!("{HEAD}format = 'parquet'\n[grid]\n'bodies[0].mass' = [1]");
    let told = open(folder.path(), &text).err().expect("no Parquet").to_string();
    assert!(told.contains(":4:10: this msd was built without Parquet"), "{told}");
    let table = folder.path().join("table.parquet");
    let written = Table::default().write(&table, TableFormat::Parquet);
    assert!(written.expect_err("no Parquet").to_string().contains("--features parquet"));
    assert!(!table.exists());
}

#[cfg(feature = "parquet")]
#[test]
fn both_formats_hold_the_same_table_and_come_back() {
    let folder = folder();
    let grid = "'solver.integrator' = ['rk4', 'explicit-euler']\n'bodies[0].mass' = [1, 2.5]\n\
        'world.gravity' = [[0, -1, 0]]\n'solver.substeps' = [4]";
    let tables = ["parquet", "csv"].map(|format| {
        let text = format!("{HEAD}format = '{format}'\n[grid]\n{grid}");
        let sweep = open(folder.path(), &text).expect("a sweep");
        let store = Store::of(&sweep, Some(folder.path().join(format)));
        assert_eq!(run(&sweep, &store, 2), counts(4, 0, 0));
        let (table, missing) = store.collect(&sweep).expect("a table");
        assert_eq!(missing, 0);
        let path = folder.path().join(format!("table.{format}"));
        table.write(&path, sweep.format()).expect("a file");
        assert_eq!(Table::read(&path, sweep.format(), &table.columns), Ok(table.clone()));
        table
    });
    assert_eq!(timeless(&tables[0]), timeless(&tables[1]));
    let table = &tables[0];
    let kind = |name: &str| table.columns[table.place(name).expect(name)].kind;
    let kinds = ["solver.integrator", "bodies[0].mass", "world.gravity", "solver.substeps"];
    assert_eq!(kinds.map(kind), [Kind::Text, Kind::Number, Kind::Text, Kind::Whole]);
    let value = |name: &str| table.rows[1][table.place(name).expect(name)].clone();
    assert_eq!(value("bodies[0].mass"), Datum::Number(2.5));
    assert_eq!(value("world.gravity"), Datum::Text("[0, -1, 0]".into()));
    assert_eq!(value("rms_error"), Datum::Nothing);
    assert!(value("cpu_seconds").as_number().is_some_and(|cpu| 0.0 < cpu));
}

#[test]
fn a_sweep_has_the_columns_that_it_names_in_the_order_of_the_table() {
    let folder = folder();
    let grid = "[grid]\n'solver.substeps' = [1, 2]\n";
    let text = format!("{HEAD}columns = ['state_hash', 'steps', 'kinetic']\n{grid}");
    let sweep = open(folder.path(), &text).expect("a sweep");
    let store = Store::of(&sweep, None);
    assert_eq!(run(&sweep, &store, 1), counts(2, 0, 0));
    let few = store.collect(&sweep).expect("a table").0;
    let names: Vec<&str> = few.columns.iter().map(|column| &*column.name).collect();
    let head = ["cell", "hash", "scene", "solver.substeps"];
    assert_eq!(names, [&head[..], &["steps", "kinetic", "state_hash"]].concat());
    // The same cells lack columns of a sweep with more; one with fewer needs no new run.
    let all = open(folder.path(), &format!("{HEAD}{grid}")).expect("a sweep");
    assert_eq!(run(&all, &Store::of(&all, None), 1), counts(2, 0, 0));
    assert_eq!(run(&sweep, &store, 1), counts(0, 2, 0));
    assert_eq!(store.collect(&sweep).expect("a table").0, few);
    for (columns, told) in [
        (
            "['state_hsh']",
            "columns[0] is \"state_hsh\"; it must be the name of a measured column, such as \
             \"state_hash\"",
        ),
        ("['steps', 'steps']", "columns[1] is \"steps\"; it must be named once"),
        ("['cell']", "columns[0] is \"cell\"; it must be the name of a measured column"),
    ] {
        let said = refused(&format!("{HEAD}columns = {columns}\n{grid}"));
        assert!(said.starts_with("sweep.toml:4:12: ") || said.contains(":4:"), "{said}");
        assert!(said.contains(told), "{said}");
    }
}

#[test]
fn a_row_tells_what_a_run_of_the_same_scene_tells() {
    let folder = folder();
    let sweep = chain(folder.path(), "'solver.substeps' = [7]");
    let store = Store::of(&sweep, None);
    run(&sweep, &store, 1);
    let (table, _) = store.collect(&sweep).expect("a table");
    let value = |name: &str| table.rows[0][table.place(name).expect(name)].clone();
    let loaded = sweep.load(&sweep.cell(0).expect("a cell")).expect("a scene");
    let mut runner = Runner::open(&loaded).expect("a runner");
    (0..6).for_each(|_| runner.step().expect("a step"));
    let hash = format!("{:016x}", msd_scene::state_hash(&runner.state()));
    assert_eq!(value("state_hash"), Datum::Text(hash));
    assert_eq!(value("total_energy"), Datum::Number(runner.energy().total()));
    assert_eq!(value("stable_substep").as_number().map(|stable| 0.0 < stable), Some(true));
    assert_eq!((value("steps"), value("duration")), (Datum::Whole(6), Datum::Number(0.1)));
    assert_eq!((value("particles"), value("springs")), (Datum::Whole(5), Datum::Whole(4)));
}

#[test]
fn what_is_done_is_not_run_again_and_what_is_broken_is() {
    let folder = folder();
    let sweep = chain(folder.path(), "'solver.substeps' = [1, 2, 3, 4]");
    let store = Store::of(&sweep, None);
    assert_eq!(store.folder(), folder.path().join("sweep"));
    let half = msd_study::sweep::run(&sweep, &store, (1..3, 1), &mut ()).expect("a run");
    assert_eq!(half, counts(2, 0, 0));
    assert_eq!(files(store.folder()).len(), 2);
    assert_eq!(store.collect(&sweep).expect("a table").1, 2);
    assert_eq!(run(&sweep, &store, 1), counts(2, 2, 0));
    let before = store.collect(&sweep).expect("a table").0;
    // Torn, empty, and the remains of another run that was killed.
    let cells = [0, 1].map(|number| store.path(&sweep.cell(number).expect("a cell")));
    let bytes = fs::read(&cells[0]).expect("a file");
    fs::write(&cells[0], &bytes[..bytes.len() / 2]).expect("a file");
    fs::write(&cells[1], "").expect("a file");
    fs::write(store.folder().join(".msd-abc.part"), "half").expect("a file");
    assert_eq!(run(&sweep, &store, 1), counts(2, 2, 0));
    let after = store.collect(&sweep).expect("a table").0;
    assert_eq!(timeless(&before), timeless(&after));
    // A sweep that has grown keeps its cells, under new numbers.
    let grown = chain(folder.path(), "'solver.substeps' = [9, 1, 2, 3, 4]\n'bodies[0].mass' = [1]");
    assert_eq!(run(&grown, &Store::of(&grown, None), 1).skipped, 4);
    let table = Store::of(&grown, None).collect(&grown).expect("a table").0;
    let cells: Vec<&Datum> = table.rows.iter().map(|row| &row[0]).collect();
    assert_eq!(cells, [0, 1, 2, 3, 4].map(Datum::Whole).iter().collect::<Vec<_>>());
}

/// A user who cancels a sweep in the third cell, which has six steps: cells done, and calls since
/// two are.
struct Ending(usize, usize);

impl Monitor for Ending {
    fn report(&mut self, progress: Progress) {
        self.0 += usize::from(progress.left.is_some());
    }

    fn proceed(&mut self) -> Result<(), Halt> {
        self.1 += usize::from(2 <= self.0);
        if self.1 <= 3 { Ok(()) } else { Err(Halt::Cancelled) }
    }
}

#[test]
fn a_sweep_that_is_ended_keeps_the_cells_that_are_done_and_goes_on_there() {
    let folder = folder();
    let sweep = chain(folder.path(), "'solver.substeps' = [1, 2, 3, 4]");
    let store = Store::of(&sweep, None);
    let mut ending = Ending(0, 0);
    let summary = msd_study::sweep::run(&sweep, &store, (0..4, 1), &mut ending);
    let summary = summary.expect("what is done");
    assert_eq!((summary.run, summary.skipped, summary.left), (2, 0, 2));
    assert_eq!(files(store.folder()).len(), 2, "two cells, and no part of a third");
    let nothing = msd_study::sweep::run(&sweep, &store, (0..4, 1), &mut Ending(2, 3));
    assert_eq!(nothing.expect("nothing"), Summary { skipped: 2, left: 2, ..Summary::default() });
}

#[test]
fn a_cell_that_diverges_is_a_result() {
    let folder = folder();
    let text = "version = 1\nscene = 'chain'\nduration = 5\n[grid]\n\
        'bodies[0].stiffness' = [10, 1e9]";
    let sweep = open(folder.path(), text).expect("a sweep");
    let store = Store::of(&sweep, None);
    assert_eq!(run(&sweep, &store, 1), counts(2, 0, 1));
    let table = store.collect(&sweep).expect("a table").0;
    let value = |row: usize, name: &str| table.rows[row][table.place(name).expect(name)].clone();
    assert_eq!(value(0, "outcome"), Datum::Text("finished".into()));
    assert_eq!(value(0, "diverged_time"), Datum::Nothing);
    assert_eq!(value(1, "outcome"), Datum::Text("diverged".into()));
    assert!(value(1, "diverged_time").as_number().is_some_and(|time| time < 1.0));
    assert!(matches!(value(1, "diverged_particle"), Datum::Whole(0..5)));
}

#[test]
fn all_cells_are_checked_before_the_first_runs() {
    let folder = folder();
    let sweep = chain(folder.path(), "'solver.substeps' = [1, 2, 0]");
    let store = Store::of(&sweep, None);
    let mut hear = |progress: Progress| assert!(progress.left.is_none());
    let told = msd_study::sweep::run(&sweep, &store, (0..3, 2), &mut hear);
    assert!(told.expect_err("refused").to_string().contains("solver.substeps is 0"));
    assert!(!store.folder().exists());
    assert_eq!(TableFormat::of(Path::new("a.CSV")), Some(TableFormat::Csv));
}

#[test]
fn a_table_with_a_row_of_another_length_is_not_written() {
    let folder = tempfile::tempdir().expect("a folder");
    let column = |name: &str| Column { name: name.into(), kind: Kind::Whole };
    let table = Table {
        columns: vec![column("a"), column("b")],
        rows: vec![vec![Datum::Whole(1), Datum::Whole(2)], vec![Datum::Whole(3)]],
    };
    for format in [TableFormat::Csv, TableFormat::Parquet] {
        let refused = table.write(&folder.path().join("t"), format).expect_err("a refusal");
        assert!(refused.to_string().ends_with("row 1 has 1 values for 2 columns"), "{refused}");
    }
}
