//! Pictures as they are, inside the page.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use maud::{Markup, html};

use super::{Picture, Report};

/// First, middle and last picture, and the animation; none where nothing was drawn.
pub(super) fn section(report: &Report<'_>) -> Option<Markup> {
    let pictures = report.pictures;
    if pictures.is_empty() && report.preview.is_none() {
        return None;
    }
    let chosen = match pictures.len() {
        0..=3 => pictures.iter().collect::<Vec<_>>(),
        n => vec![&pictures[0], &pictures[n / 2], &pictures[n - 1]],
    };
    Some(html! {
        div.pictures { @for picture in chosen { (figure(picture)) } }
        @if let Some(preview) = &report.preview { div.preview { (figure(preview)) } }
    })
}

/// One picture with its caption.
pub(super) fn figure(picture: &Picture<'_>) -> Markup {
    html! {
        figure {
            img src={ "data:image/png;base64," (STANDARD.encode(picture.png)) } alt=(picture.caption);
            figcaption { (picture.caption) }
        }
    }
}
