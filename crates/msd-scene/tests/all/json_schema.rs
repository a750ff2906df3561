//! The JSON Schema of scene files, by a validator.

use msd_scene::keys::Form;
use msd_scene::schema::{SceneFile, find};
use msd_scene::{BUILTINS, LESSONS, json_schema};
use serde_json::{Value, json};

/// The examples of the reference page that are whole scenes.
fn examples() -> impl Iterator<Item = &'static str> {
    let page = include_str!("../../../../docs/reference/scenes.md");
    let blocks = page.split("```toml\n").skip(1).filter_map(|rest| rest.split("```").next());
    blocks.filter(|block| block.contains("version = 1"))
}

#[test]
fn every_scene_that_msd_brings_is_valid() {
    let schema = json_schema();
    assert!(jsonschema::meta::is_valid(&schema));
    let validator = jsonschema::validator_for(&schema).expect("a schema");
    for text in BUILTINS.iter().chain(&LESSONS).map(|builtin| builtin.text).chain(examples()) {
        let scene: Value = toml::from_str(text).expect(text);
        let errors: Vec<String> = validator
            .iter_errors(&scene)
            .map(|error| format!("{}: {error}", error.instance_path()))
            .collect();
        assert!(errors.is_empty(), "{errors:#?}\n{text}");
    }
}

/// The schema of the key at a path.
fn at<'s>(schema: &'s Value, path: &str) -> &'s Value {
    path.split('.').fold(schema, |schema, name| {
        let schema = schema.get("items").unwrap_or(schema);
        &schema["properties"][name]
    })
}

#[test]
fn a_key_has_its_form_domain_default_and_documentation() {
    let schema = json_schema();
    let spacing = json!({
        "type": "number",
        "exclusiveMinimum": 0,
        "description": "Distance between neighbouring particles; in a mesh, in its interior \
                        lattice. Unit: m. Default: 1; of a mesh by the size of its triangles.",
    });
    assert_eq!(at(&schema, "bodies.spacing"), &spacing);
    let gravity = at(&schema, "world.gravity");
    assert_eq!(gravity["default"], json!([0, -9.82, 0]));
    assert_eq!((&gravity["minItems"], &gravity["maxItems"]), (&json!(3), &json!(3)));
    assert_eq!(at(&schema, "solver.substeps")["anyOf"][0]["maximum"], json!(4_294_967_295_u32));
    assert_eq!(at(&schema, "solver.integrator")["default"], json!("velocity-verlet"));
    assert_eq!(schema["required"], json!(["version", "bodies"]));
    let look = at(&schema, "bodies.look")["description"].as_str().expect("a text");
    assert!(!look.contains(['[', '(']), "{look}");
}

/// Names are those that are read, which serde knows: a list that is empty would refuse all.
#[test]
fn every_choice_has_names() {
    for (path, key) in SceneFile::TABLE.paths() {
        if let Form::Choice(names) = key.form {
            assert!(1 < names().len(), "{path}");
        }
    }
    let kinds = find("bodies.kind").map(|key| key.form);
    let Some(Form::Choice(names)) = kinds else { panic!("{kinds:?}") };
    assert_eq!(names(), ["rope", "cloth", "block", "mesh", "explicit"]);
}
