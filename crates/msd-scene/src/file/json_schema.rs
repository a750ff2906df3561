//! The JSON Schema of a scene file, for editors and other programs.

use crate::file::keys::{Domain, Form, KeyRow, KeyTable};
use crate::file::schema::SceneFile;
use crate::precision::Precision;
use serde_json::{Map, Value as Json, json};
use std::ops::Bound;

/// The largest whole number that every program for JSON reads exactly.
const MOST_EXACT: f64 = 9_007_199_254_740_992.0;

/// The JSON Schema, draft 2020-12, of a scene file.
///
/// It knows forms, domains, names and which kinds use a key. Rules about several values, such as
/// keys that exclude each other, are checked where a scene is opened.
pub fn json_schema() -> Json {
    let mut schema = Map::new();
    schema.insert("$schema".into(), "https://json-schema.org/draft/2020-12/schema".into());
    schema.insert("title".into(), "msd scene".into());
    schema.extend(table(SceneFile::TABLE));
    schema.into()
}

fn table(table: &KeyTable) -> Map<String, Json> {
    let properties: Map<String, Json> =
        table.keys.iter().map(|key| (key.name.into(), property(key))).collect();
    let needed = table.keys.iter().filter(|key| key.is_required());
    let needed: Vec<&str> = needed.map(|key| key.name).collect();
    let mut schema = Map::new();
    schema.insert("type".into(), "object".into());
    schema.insert("description".into(), table.what().into());
    schema.insert("properties".into(), properties.into());
    schema.insert("required".into(), needed.into());
    schema.insert("additionalProperties".into(), false.into());
    if let Some(Form::Choice(kinds)) = table.find("kind").map(|key| key.form) {
        let cases: Vec<Json> = kinds().iter().map(|kind| case(table, kind)).collect();
        schema.insert("allOf".into(), cases.into());
    }
    schema
}

/// The keys that a kind of a table lacks, and those that it needs.
fn case(table: &KeyTable, kind: &str) -> Json {
    let foreign = table.keys.iter().filter(|key| !key.is_of(kind));
    let foreign: Map<String, Json> = foreign.map(|key| (key.name.into(), false.into())).collect();
    let needed = table.keys.iter().filter(|key| key.needed.contains(&kind));
    let needed: Vec<&str> = needed.map(|key| key.name).collect();
    json!({
        "if": { "properties": { "kind": { "const": kind } }, "required": ["kind"] },
        "then": { "properties": foreign, "required": needed },
    })
}

fn property(key: &KeyRow) -> Json {
    let mut schema = value(key.form, key.domain);
    let mut about = key.what().to_owned();
    if !key.unit.is_empty() {
        about += &format!(" Unit: {}.", key.unit);
    }
    match (default(key), key.default) {
        (Some(value), _) => drop(schema.insert("default".into(), value)),
        (None, Some(words)) => about += &format!(" Default: {words}."),
        (None, None) => {}
    }
    schema.insert("description".into(), without_links(&about).into());
    schema.into()
}

/// The default, where its words are a value.
fn default(key: &KeyRow) -> Option<Json> {
    let words = key.default?.trim_matches('`');
    match key.form {
        Form::Choice(names) => names().contains(&words).then(|| words.into()),
        _ => serde_json::from_str(words).ok(),
    }
}

fn value(form: Form, domain: Domain) -> Map<String, Json> {
    let schema = match form {
        Form::Flag => json!({ "type": "boolean" }),
        Form::Text => json!({ "type": "string" }),
        Form::Number => limited("number", domain.limits(Precision::F64)),
        Form::Whole(most) => {
            let form = (Bound::Included(0.0), Bound::Included(most as f64));
            let is_count = matches!(domain, Domain::Count(..));
            limited("integer", if is_count { domain.limits(Precision::F64) } else { form })
        }
        Form::Choice(names) => json!({ "enum": names() }),
        Form::List(of, count) => {
            let least = count.unwrap_or(usize::from(matches!(domain, Domain::Filled)));
            let mut list = json!({ "type": "array", "items": value(*of, domain) });
            list["minItems"] = least.into();
            if let Some(most) = count {
                list["maxItems"] = most.into();
            }
            list
        }
        Form::Table(of) => table(of).into(),
        Form::Either(forms) => {
            let forms: Vec<Json> = forms.iter().map(|form| value(*form, domain).into()).collect();
            json!({ "anyOf": forms })
        }
    };
    match schema {
        Json::Object(schema) => schema,
        _ => Map::new(),
    }
}

fn limited(kind: &str, (least, most): (Bound<f64>, Bound<f64>)) -> Json {
    let mut schema = json!({ "type": kind });
    match least {
        Bound::Included(least) => schema["minimum"] = number(least),
        Bound::Excluded(least) => schema["exclusiveMinimum"] = number(least),
        Bound::Unbounded => {}
    }
    match most {
        Bound::Included(most) if kind == "number" || most < MOST_EXACT => {
            schema["maximum"] = number(most);
        }
        _ => {}
    }
    schema
}

/// A number, without a point where it is whole.
fn number(value: f64) -> Json {
    match value.fract() == 0.0 && value.abs() < MOST_EXACT {
        true => (value as i64).into(),
        false => value.into(),
    }
}

/// A text of the reference page with the words of its links alone, which lead nowhere elsewhere.
fn without_links(mut text: &str) -> String {
    let mut words = String::new();
    while let Some((before, after)) = text.split_once("](") {
        let (outside, name) = before.rsplit_once('[').unwrap_or(("", before));
        words.extend([outside, name]);
        text = after.split_once(')').map_or("", |(_, rest)| rest);
    }
    words + text
}
