//! The report of a study: all of it, whatever came of it, and nothing that was not in it.

use msd_core::Integrator;
use msd_report::energy_figure::chosen;
use msd_report::{csv, html, png, svg};
use msd_scene::Precision;
use msd_study::audit::Audit;
use msd_study::choice::{Choice, FRAME, Fineness};
use msd_study::errors::Errors;
use msd_study::limits::Limit;
use msd_study::space::{ErrorBalance, Share, Space, Spacing, Verdict};
use msd_study::trial::Trial;
use msd_study::{ReferenceNote, Study};
use roxmltree::{Document, Node};

/// Cost of a substep and error of one substep per frame of a method, in a scene 1.2 m across.
fn character(integrator: Integrator) -> (f64, f64) {
    match integrator {
        Integrator::ExplicitEuler => (0.9e-3, 2.0),
        Integrator::SymplecticEuler => (0.9e-3, 0.12),
        Integrator::VelocityVerlet => (1.0e-3, 0.05),
        Integrator::Rk4 => (3.9e-3, 0.9),
        Integrator::DormandPrince => (8e-3, 0.0),
        Integrator::BackwardEuler => (20e-3, 0.16),
        Integrator::ImplicitMidpoint => (22e-3, 0.04),
        Integrator::Xpbd => (1.6e-3, 0.2),
        _ => panic!("no character of {integrator} is known"),
    }
}

fn errors(rms: f64) -> Errors {
    Errors {
        rms,
        max: 3.1 * rms,
        velocity: 8.0 * rms,
        centre: 0.2 * rms,
        energy: 40.0 * rms,
        momentum: 0.7 * rms,
        penetration: 0.0,
    }
}

fn trial(integrator: Integrator, fineness: Fineness, precision: Precision, sizes: usize) -> Trial {
    let (price, coarse) = character(integrator);
    let (count, error) = match fineness {
        Fineness::Substeps(count) => {
            (f64::from(count), coarse * f64::from(count).powi(-(integrator.order() as i32)))
        }
        Fineness::Tolerance(tolerance) => (3.0 * tolerance.powf(-0.19), 4.0 * tolerance),
    };
    let (floor, faster) = if precision == Precision::F32 { (3e-6, 0.7) } else { (1e-12, 1.0) };
    let explicit = Integrator::EXPLICIT.contains(&integrator);
    let limit = if integrator == Integrator::ExplicitEuler { 100.0 } else { 8.0 };
    let diverged = explicit && count < limit;
    let energy = |row: usize| {
        let time = row as f64 / 30.0;
        exact_energy(time) * (1.0 - 2.0 * error * time)
    };
    Trial {
        choice: Choice { integrator, fineness, precision },
        cost: 60.0 * price * faster * count * 0.01,
        errors: (!diverged).then(|| errors(libm::hypot(error, floor))),
        energies: (0..if diverged { 4 } else { sizes }).map(energy).collect(),
        gained: 0.0,
        diverged: diverged.then(|| "step 7: particle 12 left the world".into()),
    }
}

fn exact_energy(time: f64) -> f64 {
    9.81 - 4.0 * (1.0 - (-time).exp()) + 0.3 * (7.0 * time).sin()
}

/// Every method, in both precisions, at many finenesses.
fn full() -> Study {
    let mut trials = Vec::new();
    let times: Vec<f64> = (1..=60).map(|row| f64::from(row) / 30.0).collect();
    for integrator in Integrator::ALL {
        for precision in [Precision::F32, Precision::F64] {
            for level in 0..10 {
                let fineness = if integrator.is_adaptive() {
                    Fineness::Tolerance(10f64.powi(-1 - level))
                } else {
                    Fineness::Substeps(1 << level)
                };
                trials.push(trial(integrator, fineness, precision, times.len()));
            }
        }
    }
    let audited = |(row, integrator): (usize, Integrator)| Audit {
        choice: Choice { integrator, fineness: Fineness::Substeps(8), precision: Precision::F64 },
        stiffness: 1.0 - 0.004 * row as f64,
        damping: 1.0 + 0.3 * row as f64,
        added_damping: 0.003 * row as f64,
        period: -0.002 * row as f64,
    };
    let limit = |integrator: Integrator| {
        let explicit = Integrator::EXPLICIT.contains(&integrator);
        let predicted = if explicit { 2.1e-3 } else { f64::INFINITY };
        match integrator {
            Integrator::ExplicitEuler => Limit { integrator, predicted: 0.0, observed: None },
            Integrator::Xpbd => Limit { integrator, predicted, observed: Some(0.0) },
            _ => Limit { integrator, predicted, observed: explicit.then_some(2.3e-3) },
        }
    };
    Study {
        scene: "jelly".into(),
        title: "A cube of jelly falls on the ground and wobbles".into(),
        particles: 1000,
        springs: 7560,
        size: 1.2,
        duration: 2.0,
        wanted: 1e-3,
        reference: ReferenceNote {
            tolerance: 1e-11,
            substeps: 0,
            uncertainty: 4e-9,
            reliable_until: 1.6,
            horizon: Some(1.6),
            seconds: 12.3,
        },
        energies: times.iter().map(|&time| exact_energy(time)).collect(),
        times,
        trials,
        left_out: vec!["xpbd with 1024 substeps: it would have taken 40 s".into()],
        limits: Integrator::ALL.map(limit).to_vec(),
        audit: Integrator::ALL.into_iter().enumerate().map(audited).collect(),
        space: None,
        balance: None,
        on_device: None,
        words: "For an error of 1.0 mm use velocity-verlet with 8 substeps in f32.".into(),
        machine: "Processor of 2 cores at 3 GHz, Linux".into(),
        date: "2026-11-21".into(),
    }
}

type Case = (&'static str, Study);

/// A study changed in some way.
fn with(change: fn(&mut Study)) -> Study {
    let mut study = full();
    change(&mut study);
    study
}

/// Studies that came to little.
fn poor() -> Vec<Case> {
    let empty = |study: &mut Study| {
        study.trials.clear();
        study.limits.clear();
        study.audit.clear();
        study.left_out.clear();
        study.times.clear();
        study.energies.clear();
        study.words.clear();
    };
    vec![
        ("nothing", with(empty)),
        ("one trial", with(|study| study.trials.truncate(1))),
        ("one sound trial", with(|study| study.trials = vec![study.trials[29].clone()])),
        ("all diverged", with(|study| study.trials.retain(|trial| trial.errors.is_none()))),
    ]
}

/// Studies with numbers that no figure can hold.
fn wild() -> Vec<Case> {
    let exact = |study: &mut Study| {
        study.trials.iter_mut().for_each(|trial| trial.errors = Some(Errors::default()));
        (study.reference.uncertainty, study.reference.tolerance) = (0.0, 0.0);
    };
    let no_numbers = |study: &mut Study| {
        fill(study, f64::NAN);
        study.audit.iter_mut().for_each(|audit| audit.damping = f64::NAN);
        study.limits.iter_mut().for_each(|limit| limit.predicted = f64::NAN);
    };
    let infinite = |study: &mut Study| {
        fill(study, f64::INFINITY);
        (study.size, study.wanted) = (f64::INFINITY, f64::INFINITY);
        study.reference.uncertainty = f64::INFINITY;
    };
    let nothing = |study: &mut Study| {
        (study.size, study.wanted, study.duration) = (0.0, 0.0, 0.0);
        study.trials.iter_mut().for_each(|trial| trial.cost = 0.0);
    };
    let huge_and_tiny = |study: &mut Study| {
        for (row, trial) in study.trials.iter_mut().enumerate() {
            trial.cost = if row % 2 == 0 { 1e-300 } else { 1e300 };
            trial.errors = Some(errors(trial.cost));
            trial.energies.iter_mut().for_each(|energy| *energy *= 1e300);
        }
        study.energies.fill(0.0);
    };
    vec![
        ("no error", with(exact)),
        ("no numbers", with(no_numbers)),
        ("infinite", with(infinite)),
        ("no size, no cost", with(nothing)),
        ("huge and tiny", with(huge_and_tiny)),
    ]
}

fn fill(study: &mut Study, value: f64) {
    for trial in &mut study.trials {
        trial.errors = Some(errors(value));
        trial.cost = value;
        trial.energies.fill(value);
    }
    study.energies.fill(-value);
}

/// A study whose words would break a page that took them for its own.
fn rude() -> Study {
    with(|study| {
        for text in [&mut study.scene, &mut study.title, &mut study.words, &mut study.machine] {
            *text = "</style><script>alert('1 & 2')</script>\u{0}\u{b}\u{ffff}\"".into();
        }
        study.left_out = vec![study.scene.clone()];
        study.trials[0].diverged = Some(study.scene.clone());
    })
}

fn all() -> Vec<Case> {
    let last = [("rude", rude()), ("full", full())];
    poor().into_iter().chain(wild()).chain(last).collect()
}

/// The page as a tree. It uses nothing that HTML allows beyond XML, but for the first line, names
/// without a value and tags without an end.
fn tree(page: &str) -> String {
    let page = page.strip_prefix("<!DOCTYPE html>\n").expect("HTML 5 starts with its name");
    let (before, rest) = page.split_once("<script>").expect("one script");
    let (_, after) = rest.split_once("</script>").expect("one script");
    assert!(!after.contains("<script"), "a script that is not ours");
    let mut page = format!("{before}{after}").replace(" hidden>", ">");
    let mut at = 0;
    while let Some(start) = page[at..].find("<meta") {
        let end = at + start + page[at + start..].find('>').expect("a tag ends");
        page.insert(end, '/');
        at = end;
    }
    page
}

fn parsed(text: &str) -> Document<'_> {
    Document::parse(text).unwrap_or_else(|error| panic!("{error}"))
}

fn targets<'a>(drawing: &'a Document) -> Vec<Node<'a, 'a>> {
    drawing.descendants().filter(|node| node.has_attribute("data-method")).collect()
}

fn text(node: Node<'_, '_>) -> String {
    node.descendants().filter(Node::is_text).filter_map(|node| node.text()).collect()
}

#[test]
fn every_page_and_drawing_is_well_formed_and_has_a_target_per_trial() {
    for (name, study) in all() {
        let drawing = svg(&study);
        let drawing = parsed(&drawing);
        assert_eq!(targets(&drawing).len(), study.trials.len(), "{name}");
        let page = tree(&html(&study));
        let page = parsed(&page);
        assert_eq!(targets(&page).len(), study.trials.len(), "{name}");
        for node in drawing.descendants().chain(page.descendants()) {
            for attribute in node.attributes() {
                let value = attribute.value();
                assert!(!value.contains("NaN") && value != "inf", "{name}: {attribute:?}");
            }
        }
    }
}

#[test]
fn a_page_needs_nothing_beside_it() {
    let page = html(&full());
    for outside in ["src=", "href=", "url(", "@import", "fetch(", "<link"] {
        assert!(!page.contains(outside), "{outside}");
    }
    let addresses = page.matches("http").count();
    assert_eq!(addresses, page.matches("xmlns=\"http://www.w3.org/2000/svg\"").count());
}

#[test]
fn text_from_outside_is_shown_letter_by_letter() {
    let study = rude();
    let page = tree(&html(&study));
    let page = parsed(&page);
    let shown = "</style><script>alert('1 & 2')</script>\u{fffd}\u{fffd}\u{fffd}\"";
    let heading = page.descendants().find(|node| node.has_tag_name("h1")).expect("a heading");
    assert_eq!(text(heading), shown);
    let in_table = |node: &Node| node.has_tag_name("td") && text(*node) == shown;
    assert!(page.descendants().any(|node| in_table(&node)), "why the first trial diverged");
    let drawing = svg(&study);
    let drawing = parsed(&drawing);
    let label = drawing.root_element().attribute("aria-label").expect("a label");
    assert!(label.starts_with(shown), "{label}");
    assert!(targets(&drawing).iter().any(|target| text(*target).contains(shown)));
}

#[test]
fn a_point_says_its_setting_its_error_and_its_cost() {
    let study = full();
    let drawing = svg(&study);
    let drawing = parsed(&drawing);
    for target in targets(&drawing) {
        let row: usize = target.attribute("data-row").expect("a row").parse().expect("a number");
        let said = text(target);
        assert!(said.starts_with(&study.trials[row].choice.to_string()), "{said}");
        assert!(said.contains("per frame"), "{said}");
        let diverged = study.trials[row].errors.is_none();
        assert_eq!(said.contains("diverged: step 7"), diverged, "{said}");
        assert_eq!(said.contains("on the Pareto front"), study.front().contains(&row), "{said}");
    }
    // Verlet, 8 substeps, f64: 0.05 / 8² m = 0.78 mm of 1.2 m, and 0.01 · 60 · 1 ms · 8 / 60.
    let ours = "velocity-verlet, 8 substeps, f64\nerror 781 µm, 0.0651 % of the size\n80.0 µs";
    assert!(targets(&drawing).iter().any(|target| text(*target).starts_with(ours)));
}

#[test]
fn points_lie_where_their_cost_and_error_put_them() {
    let study = full();
    let drawing = svg(&study);
    let drawing = parsed(&drawing);
    let place = |target: &Node, name| -> f64 {
        target.attribute(name).expect("a place").parse().expect("a number")
    };
    let mut sound = Vec::new();
    for target in targets(&drawing) {
        let row = place(&target, "data-row") as usize;
        // Far below the uncertainty of the reference points lie on the lower edge.
        let told = study.reference.uncertainty / 30.0 < study.trials[row].error();
        if study.trials[row].errors.is_some() && told {
            sound.push((row, place(&target, "cx"), place(&target, "cy")));
        }
    }
    // Equal factors are equal distances: one scale for all pairs of points, to a dot each.
    let scale = |value: fn(&Trial) -> f64, at: fn(&(usize, f64, f64)) -> f64| {
        let of = |spot: &(usize, f64, f64)| value(&study.trials[spot.0]).log10();
        let least = sound.iter().min_by(|a, b| of(a).total_cmp(&of(b))).expect("points");
        let most = sound.iter().max_by(|a, b| of(a).total_cmp(&of(b))).expect("points");
        let scale = (at(most) - at(least)) / (of(most) - of(least));
        for spot in &sound {
            let expected = at(least) + scale * (of(spot) - of(least));
            assert!((at(spot) - expected).abs() <= 2.0, "row {}", spot.0);
        }
        scale
    };
    assert!(scale(|trial| trial.cost, |spot| spot.1) > 0.0);
    assert!(scale(Trial::error, |spot| spot.2) < 0.0);
}

#[test]
fn the_front_is_ringed_and_listed_cheapest_first() {
    let study = full();
    let page = tree(&html(&study));
    let page = parsed(&page);
    let table = page.descendants().find(|node| node.has_tag_name("tbody")).expect("a table");
    let rows: Vec<usize> =
        table.children().filter_map(|row| row.attribute("data-row")?.parse().ok()).collect();
    assert_eq!(rows, study.front());
    let bold: Vec<_> = table.children().filter(|row| row.attribute("class").is_some()).collect();
    let cheapest = study.front().into_iter().find(|&row| study.trials[row].error() <= 1e-3);
    assert_eq!(bold.len(), 1);
    assert_eq!(bold[0].attribute("data-row").map(str::to_owned), cheapest.map(|r| r.to_string()));
    // A ring is a closed line of 33 points; one more explains it in the head.
    let rings = |study: &Study| {
        let drawing = svg(study);
        let lines: Vec<usize> = parsed(&drawing)
            .descendants()
            .filter(|node| node.has_tag_name("polyline"))
            .filter_map(|line| Some(line.attribute("points")?.split_whitespace().count()))
            .collect();
        lines.into_iter().filter(|&count| count == 33).count()
    };
    assert_eq!(rings(&study), study.front().len() + 1);
}

#[test]
fn the_table_of_numbers_reads_back_the_same() {
    let study = full();
    let bytes = csv(&study);
    let mut reader = ::csv::Reader::from_reader(bytes.as_slice());
    let heads = reader.headers().expect("heads").clone();
    let column = |name: &str| heads.iter().position(|head| head == name).expect(name);
    let rows: Vec<::csv::StringRecord> = reader.records().map(|row| row.expect("a row")).collect();
    assert_eq!(rows.len(), study.trials.len());
    for (number, (row, trial)) in rows.iter().zip(&study.trials).enumerate() {
        let float = |name: &str| row[column(name)].parse::<f64>().ok();
        assert_eq!(&row[column("integrator")], trial.choice.integrator.name());
        assert_eq!(&row[column("precision")], trial.choice.precision.name());
        match trial.choice.fineness {
            Fineness::Substeps(count) => assert_eq!(float("substeps"), Some(f64::from(count))),
            Fineness::Tolerance(small) => assert_eq!(float("tolerance"), Some(small)),
        }
        assert_eq!(float("cpu_seconds_per_second"), Some(trial.cost));
        assert_eq!(float("ms_per_frame"), Some(1e3 * FRAME * trial.cost));
        assert_eq!(float("rms_error_m"), trial.errors.map(|errors| errors.rms));
        assert_eq!(float("relative_error"), trial.errors.map(|errors| errors.rms / 1.2));
        assert_eq!(float("max_error_m"), trial.errors.map(|errors| errors.max));
        assert_eq!(float("energy_error_j"), trial.errors.map(|errors| errors.energy));
        let on_front = study.front().contains(&number);
        assert_eq!(&row[column("on_front")], if on_front { "true" } else { "false" });
        assert_eq!(&row[column("diverged")], trial.diverged.as_deref().unwrap_or(""));
    }
}

#[test]
fn a_picture_has_its_size_and_the_colours_of_its_methods() {
    for (name, study) in [("full", full()), poor().swap_remove(0)] {
        let picture = image::load_from_memory(&png(&study)).expect("a picture").to_rgb8();
        assert_eq!(picture.dimensions(), (1920, 1224), "{name}");
        let has = |colour: [u8; 3]| picture.pixels().filter(|pixel| pixel.0 == colour).count();
        // Letters are there even where nothing was tried, on a machine without fonts.
        let dark = picture.pixels().filter(|pixel| pixel.0[0] < 90).count();
        assert!(dark > 1000, "{name}: {dark}");
        // Verlet's blue and the broad front: a line of 2 pixels from side to side.
        let drawn = has([0, 114, 178]) > 200 && has([206, 199, 184]) > 1000;
        assert_eq!(drawn, name == "full", "{name}");
    }
}

#[test]
fn limits_are_said_in_words_where_there_is_none() {
    let page = tree(&html(&full()));
    let page = parsed(&page);
    let rows: Vec<String> = page
        .descendants()
        .filter(|node| node.has_tag_name("tr") && node.attribute("data-row").is_none())
        .map(text)
        .collect();
    // 1/60 s / 2.1 ms = 7.9; 2.3 / 2.1 = 1.095.
    for said in [
        "rk42.10 ms 8 per frame2.30 ms 8 per frame1.10",
        "explicit-eulernone: no substep is stablenot looked for–",
        "backward-eulernone: every substep is stablenot looked for–",
        "xpbdnone: every substep is stablenone: no substep is stable–",
    ] {
        assert!(rows.iter().any(|row| row == said), "{said} in {rows:#?}");
    }
}

#[test]
fn the_worst_of_each_column_of_the_audit_is_marked() {
    let page = tree(&html(&full()));
    let page = parsed(&page);
    let marked = page.descendants().filter(|node| node.attribute("class") == Some("worst"));
    let marked: Vec<String> = marked.map(text).collect();
    // The last of eight: 1 − 7 · 0.4 %, 1 + 7 · 30 %, −7 · 0.2 %.
    assert_eq!(marked, ["97.2 %", "310.0 %", "−1.40 %"]);
}

#[test]
fn the_energy_is_shown_of_one_trial_per_method_nearest_to_what_is_wanted() {
    let study = full();
    let shown = chosen(&study);
    assert_eq!(shown.len(), Integrator::ALL.len());
    for trial in shown {
        let off = |trial: &Trial| (trial.error() / study.wanted).ln().abs();
        let others = study.of(trial.choice.integrator);
        assert!(others.into_iter().all(|other| off(trial) <= off(other)), "{}", trial.choice);
    }
}

/// A study with the error of the spacing.
fn balanced(study: &mut Study) {
    let share = |error: f64, remedy: &str| {
        Some(Share { error, is_bound: false, remedy: remedy.into(), left: 0.25 * error, cost: 0.5 })
    };
    let spacing = |parts: u32, error: f64| Spacing {
        parts,
        particles: 1000 * parts.pow(3) as usize,
        springs: 9000,
        error: Some(error),
        seconds: 1.0,
    };
    study.space = Some(Space {
        duration: 2.0,
        compared: 2.0,
        points: 1000,
        spacings: vec![spacing(1, 12e-3), spacing(2, 3e-3)],
        verdict: Verdict::Known {
            error: 12e-3,
            band: 9e-3,
            order: 2.0,
            is_seen: false,
            until: 1.5,
        },
        stopped: "1/4 of the spacing takes about 80 s".into(),
    });
    study.balance = Some(ErrorBalance {
        choice: study.trials[0].choice,
        cost: 0.1,
        space: share(12e-3, "half the spacing"),
        time: share(3e-6, "16 substeps"),
        precision: share(1e-15, ""),
        advice: "refine the mesh: space costs you 12 mm, time 3 µm".into(),
    });
}

#[test]
fn errors_of_space_time_and_precision_stand_side_by_side() {
    let page = html(&with(balanced));
    for said in
        ["Refine the mesh", "12.0 mm", "3.00 µm", "half the spacing", "nothing makes it less"]
    {
        assert!(page.contains(said), "{said}");
    }
    assert!(page.contains("up to t = 1.5 s") && page.contains("which two spacings cannot tell"));
    assert!(page.contains("8000 particles"));
    let page = html(&full());
    assert!(page.contains("The error of space is not included"));
    // Values that no figure can hold are drawn all the same.
    for value in [0.0, f64::NAN, f64::INFINITY, 1e-300] {
        let mut study = with(balanced);
        let balance = study.balance.as_mut().unwrap();
        balance.time = balance.time.clone().map(|time| Share { error: value, cost: value, ..time });
        balance.space = None;
        study.size = value;
        assert!(html(&study).contains("not known"));
    }
}
