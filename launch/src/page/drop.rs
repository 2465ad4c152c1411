//! How one capture falls, filled in several ways: pictures over time and curves.

use maud::html;

use super::pictures::figure;
use super::{Chart, Picture, chart, document};

/// The page; `facts` are what was dropped and how.
pub(crate) fn html(title: &str, facts: &[String], pictures: &[Picture<'_>], charts: &[Chart<'_>]) -> String {
    let body = html! {
        header {
            h1 { (title) }
            @for fact in facts { p { (fact) } }
        }
        main {
            section { h2 { "Over time" } @for picture in pictures { (figure(picture)) } }
            section { h2 { "Heights and shapes" } @if let Some(charts) = chart::section(charts) { (charts) } }
        }
        footer { "Every number on this page was measured in the runs that it describes. SI units." }
    };
    document(title, &body)
}
