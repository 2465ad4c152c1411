//! How one capture falls, filled in several ways: pictures over time and curves.

use maud::{DOCTYPE, PreEscaped, html};

use super::pictures::figure;
use super::{Chart, Picture, chart};

/// The page; `facts` are what was dropped and how.
pub(crate) fn html(title: &str, facts: &[String], pictures: &[Picture<'_>], charts: &[Chart<'_>]) -> String {
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (title) }
                style { (PreEscaped(include_str!("style.css"))) }
            }
            body {
                header {
                    h1 { (title) }
                    @for fact in facts { p { (fact) } }
                }
                main {
                    section { h2 { "Over time" } @for picture in pictures { (figure(picture)) } }
                    section { h2 { "Heights and shapes" } @if let Some(charts) = chart::section(charts) { (charts) } }
                }
                footer { "Every number on this page was measured in the runs that it describes. SI units." }
            }
        }
    };
    page.into_string()
}
