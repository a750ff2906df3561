//! The sheet of a lesson: a page for students, and one for the teacher.

use maud::{DOCTYPE, PreEscaped, html};
use msd_core::Settings;
use msd_scene::Loaded;
use msd_study::lesson::Question;
use msd_study::quantity::rounded;

const STYLE: &str = "body{font:16px/1.5 sans-serif;max-width:44em;margin:2em auto;padding:0 1em}
td,th{text-align:left;vertical-align:top;padding:.2em 1.5em .2em 0}
.answer{margin:3em 0}
@media print{body{font-size:12pt;margin:0}.teacher{break-before:page}}";

/// Returns the sheet of the lesson of a scene with its settings, HTML: the question on one page,
/// the answer of msd and the known mistakes on the next.
///
/// # Errors
/// A line on why there is no lesson, or no answer.
pub fn lesson_sheet(loaded: &Loaded, settings: Settings) -> Result<String, String> {
    let lesson = loaded.lesson.as_deref().ok_or("the scene has no lesson")?;
    let question = Question { lesson, scene: &loaded.scene, settings };
    let (right, wrong) = (question.answer()?, question.wrong_answers()?);
    let (name, title, unit) = (&loaded.name, &loaded.title, lesson.answer.unit());
    let percent = rounded(100.0 * lesson.tolerance, 2);
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (title) }
                style { (PreEscaped(STYLE)) }
            }
            body {
                section {
                    h1 { (title) }
                    p { strong { (lesson.question) } }
                    ol { @for step in &lesson.steps { "\n" li { (step) } } }
                    p.answer { "Answer: ____________________ " (unit) }
                }
                "\n"
                section.teacher {
                    h2 { "For the teacher: " (title) }
                    p {
                        "Open the lesson by " code { "msd view " (name) } ", by "
                        code { "#scene=" (name) } " after the address of the page, or by the "
                        "button Lessons."
                    }
                    p {
                        "The answer is " strong { (rounded(right, 3)) " " (unit) }
                        ", computed by msd from the scene. Answers within " (percent)
                        " % are right. " (lesson.reason)
                    }
                    p { (lesson.theory) }
                    table {
                        tr { th { "Typical mistake" } th { "What msd says" } }
                        @for (number, row) in wrong.iter().zip(&lesson.mistakes) {
                            "\n"
                            tr { td { (rounded(*number, 3)) " " (unit) } td { (row.says) } }
                        }
                    }
                }
            }
        }
    };
    Ok(page.into_string() + "\n")
}
