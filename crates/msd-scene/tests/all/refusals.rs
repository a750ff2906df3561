//! Several refusals of one scene file at once.

use msd_scene::{FileError, SceneFormat, parse};

fn refusal(text: &str) -> FileError {
    parse(text, SceneFormat::Toml, "s.toml").expect_err(text)
}

#[test]
fn a_file_with_mistakes_of_every_kind_is_refused_with_all_of_them_in_its_order() {
    let text = "version = 1
[solver]
integrator = 'rk5'
substeps = 0
[world]
gravty = [0, -1, 0]
gravity = [0, 'down', 0]
[[bodies]]
kind = 'cube'
size = [4, 4, 4]
mass = -1
color = '#fff'
[[bodies]]
size = [3]
spacing = nan
[[pins]]
at = 5
";
    let told = [
        "s.toml:3:14: solver.integrator is \"rk5\"; it must be one of",
        "s.toml:4:12: solver.substeps is 0; it must be from 1 to 4294967295",
        "s.toml:6:1: unknown key `gravty` in world; did you mean `gravity`?",
        "s.toml:7:15: world.gravity[1] is \"down\"; it must be a number",
        "s.toml:9:8: bodies[0].kind is \"cube\"; it must be one of",
        "s.toml:11:8: bodies[0].mass is -1; it must be positive and finite",
        "s.toml:12:1: unknown key `color` in bodies[0]; did you mean",
        "s.toml:13:1: bodies[1] lacks the key `kind`",
        "s.toml:15:11: bodies[1].spacing is NaN; it must be positive and finite",
        "s.toml:17:6: pins[0].at is 5; it must be a list",
    ];
    let message = refusal(text).to_string();
    let lines: Vec<&str> = message.lines().collect();
    assert_eq!(lines.len(), told.len(), "{message}");
    for (line, told) in lines.iter().zip(told) {
        assert!(line.starts_with(told), "{line}\n{told}");
    }
}

#[test]
fn what_follows_from_a_mistake_is_not_refused_with_it() {
    // Only with the precision that was meant is the mass in its domain. The pin is of a particle
    // that the body would have, and `size` belongs to the kind that was meant.
    for (text, key) in [
        ("[solver]\nprecision = 'f46'\n[[bodies]]\nkind='rope'\nsize=[3]\nmass=1e-40", "precision"),
        ("[[bodies]]\nkind='rop'\nsize=[30]\n[[pins]]\nparticle=20", "kind"),
        ("[[bodies]]\nkind='rope'\nsize=[0]\n[[pins]]\nparticle=20", "size"),
        ("[[bodies]]\nkind='rope'\nsiz=[30]\n[[pins]]\nparticle=20", "siz"),
    ] {
        let error = refusal(&format!("version = 1\n{text}"));
        assert!(error.each().len() == 1 && error.to_string().contains(key), "{error}");
    }
}

#[test]
fn at_most_ten_are_given() {
    let bodies = "[[bodies]]\nkind = 'rope'\nsize = [3]\nmass = -1\n".repeat(30);
    let error = refusal(&format!("version = 1\n{bodies}"));
    assert_eq!(error.each().len(), 10);
    assert!(error.each()[9].to_string().starts_with("s.toml:41:8: bodies[9].mass"), "{error}");
}

#[test]
fn a_refusal_of_keys_that_do_not_fit_together_comes_with_those_of_single_values() {
    let text = "version = 1\n[solver]\nstep = 'auto'\nsubsteps = 3\n[[bodies]]\nkind = 'rope'\n\
                size = [3]\ndamping = -2";
    let error = refusal(text).to_string();
    assert!(error.contains("exclude each other\ns.toml:8:11: bodies[0].damping is -2"), "{error}");
}
