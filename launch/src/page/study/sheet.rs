//! Page of a sheet: pictures in rows and columns, and what the runs measure.

use maud::{Markup, html};

use super::super::number::{count, maybe};
use super::super::tables::table;
use super::Page;
use super::suites::whole;
use crate::study::outcome::Class;
use crate::study::sheet::{Cell, Sheet, Tile};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use cosplat_viewer::png;

/// The page; a tile a cell, row by row.
pub(crate) fn sheet(page: &Page<'_>, sheet: &Sheet, cells: &[Cell], tiles: &[Option<Tile>]) -> String {
    let at = sheet.at_s.map_or_else(|| "at the end".into(), |at| format!("at {at} s"));
    let lead = format!("{} runs of the scene {}; pictures {at}.", cells.len(), sheet.scene);
    let title = if sheet.title.is_empty() { &sheet.name } else { &sheet.title };
    let body = html! {
        section id="pictures" { (pictures(sheet, cells, tiles)) }
        section id="runs" {
            h2 { "What the runs measure" }
            (runs(cells))
            p {
                "Dent: how far the striker goes on, along the way it came, from the window in which it first touches to where \
                 it first turns; what gives way as a whole counts, and there is none where it slides off. Rebound: its largest \
                 speed back before it turns again, over its speed at the touch. Time: of the whole run, pictures included. \
                 Core: processor time of the solvers."
            }
        }
    };
    whole(page, title, &lead, &body)
}

fn pictures(sheet: &Sheet, cells: &[Cell], tiles: &[Option<Tile>]) -> Markup {
    let across = sheet.columns.len().max(1);
    html! {
        div.table { table {
            thead { tr { th {} @for column in &sheet.columns { th { (column.name()) } } } }
            tbody {
                @for ((row, cells), tiles) in sheet.rows.iter().zip(cells.chunks(across)).zip(tiles.chunks(across)) {
                    tr { th { (row.name()) } @for (cell, tile) in cells.iter().zip(tiles) { td { (picture(cell, tile.as_ref())) } } }
                }
            }
        } }
    }
}

fn picture(cell: &Cell, tile: Option<&Tile>) -> Markup {
    let mut bytes = Vec::new();
    let is_drawn = tile.is_some_and(|tile| png::encode(&mut bytes, &tile.picture()).is_ok());
    let name = format!("{} {}", cell.row, cell.column);
    html! {
        @if is_drawn { img src={ "data:image/png;base64," (STANDARD.encode(&bytes)) } alt=(name); }
        @else { (outcome(cell)) }
    }
}

fn runs(cells: &[Cell]) -> Markup {
    let head = [
        ("Row", ""),
        ("Column", ""),
        ("Outcome", ""),
        ("Dent [mm]", "n"),
        ("Rebound", "n"),
        ("Speed at the touch [m/s]", "n"),
        ("Touches at [s]", "n"),
        ("Windows", "n"),
        ("Substeps", "n"),
        ("Time [s]", "n"),
        ("Core [s]", "n"),
    ];
    let row = |cell: &Cell| {
        let impact = cell.impact.as_ref();
        let number = |value: Option<u64>| value.map_or_else(|| "–".into(), count);
        vec![
            html! { (cell.row) },
            html! { (cell.column) },
            outcome(cell),
            html! { (maybe(impact.and_then(|i| i.dent_m).map(|m| 1e3 * m))) },
            html! { (maybe(impact.map(|i| i.rebound))) },
            html! { (maybe(impact.map(|i| i.approach_m_s))) },
            html! { (maybe(impact.map(|i| i.touch_s))) },
            html! { (number(cell.windows)) },
            html! { (number(cell.substeps)) },
            html! { (maybe(cell.wall_s)) },
            html! { (maybe(cell.core_s)) },
        ]
    };
    table(&head, cells.iter().map(row).collect())
}

fn outcome(cell: &Cell) -> Markup {
    let class = match cell.outcome {
        Some(Class::Correct) => "good",
        Some(Class::Degraded | Class::Refused) => "warn",
        Some(Class::Failed) | None => "bad",
    };
    html! {
        span class=(class) { (cell.outcome.map_or("not run", Class::word)) }
        @if let Some(why) = &cell.why { ": " (why) }
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::tests::assert_well_formed;
    use super::*;
    use crate::study::case::Level;
    use crate::study::sheet::{Impact, Line};

    #[test]
    fn every_cell_has_its_place() {
        let line = |value: &str| Line { values: vec![("body.a.material".into(), Level::of(value))] };
        let cell = |column: &str, impact| Cell {
            row: "can".into(),
            column: column.into(),
            outcome: Some(Class::Correct),
            why: None,
            impact,
            windows: Some(2),
            substeps: Some(30),
            wall_s: Some(1.5),
            core_s: None,
            state_hash: None,
            folder: String::new(),
            picture: None,
        };
        let struck = Impact { touch_s: 0.1, approach_m_s: 2.0, dent_m: Some(0.0215), rebound: 0.25 };
        let sheet = Sheet {
            name: "x".into(),
            title: "A <sheet>".into(),
            scene: "x".into(),
            at_s: Some(0.1),
            striker: None,
            rows: vec![line("can")],
            columns: vec![line("rock"), line("log")],
        };
        let command = ["cosplat".to_owned()];
        let page = Page { cases: &[], catalogue: &[], command: &command, version: "1.2.3", machine: "a machine" };
        let tiles = [Some(Tile::of(2, 1, &[0.5; 6])), None];
        let text = super::sheet(&page, &sheet, &[cell("rock", Some(struck)), cell("log", None)], &tiles);
        assert_well_formed(&text);
        assert_eq!(text.matches("data:image/png").count(), 1);
        assert!(text.contains("21.50") && text.contains("A &lt;sheet&gt;"), "{text}");
    }
}
