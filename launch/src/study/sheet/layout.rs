//! The pictures of a sheet beside each other.

use cosplat_viewer::Picture;

/// Largest width of a picture on a sheet \[px\].
const WIDTH: usize = 320;
/// What stands where a run has no picture: a light grey.
const NOTHING: [f32; 4] = [0.9, 0.9, 0.9, 1.0];

/// A picture on a sheet.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Tile {
    width: usize,
    height: usize,
    /// Red, green, blue from 0 to 1, row by row.
    rgb: Vec<[f32; 3]>,
}

impl Tile {
    /// Shrinks a picture (red, green, blue from 0 to 1, row by row) by the smallest whole number that reaches the width
    /// of a tile: means of squares of display values. What is left over at the right and lower edge is cut.
    pub(crate) fn of(width: usize, height: usize, values: &[f32]) -> Self {
        let reduce = width.div_ceil(WIDTH).max(1);
        let (small_width, small_height) = (width / reduce, height / reduce);
        let mean = |column: usize, row: usize| {
            let mut sum = [0.0; 3];
            for y in row * reduce..(row + 1) * reduce {
                for x in column * reduce..(column + 1) * reduce {
                    for (sum, value) in sum.iter_mut().zip(&values[3 * (y * width + x)..]) {
                        *sum += value;
                    }
                }
            }
            sum.map(|s| s / (reduce * reduce) as f32)
        };
        let rgb = (0..small_height).flat_map(|row| (0..small_width).map(move |column| (column, row)));
        Self { width: small_width, height: small_height, rgb: rgb.map(|(column, row)| mean(column, row)).collect() }
    }

    /// As a picture of its own.
    pub(crate) fn picture(&self) -> Picture {
        side_by_side(&[vec![Some(self.clone())]])
    }
}

/// Rows of tiles as one picture; a missing one is grey. All places are as large as the largest tile.
pub(crate) fn side_by_side(rows: &[Vec<Option<Tile>>]) -> Picture {
    let tiles = || rows.iter().flatten().flatten();
    let width = tiles().map(|t| t.width).max().unwrap_or(0);
    let height = tiles().map(|t| t.height).max().unwrap_or(0);
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let whole = (columns * width, rows.len() * height);
    let mut rgba = vec![NOTHING; whole.0 * whole.1];
    for (row, tiles) in rows.iter().enumerate() {
        for (column, tile) in tiles.iter().enumerate() {
            let Some(tile) = tile else { continue };
            for (y, line) in tile.rgb.chunks_exact(tile.width.max(1)).enumerate() {
                let begin = (row * height + y) * whole.0 + column * width;
                for (place, &[r, g, b]) in rgba[begin..].iter_mut().zip(line) {
                    *place = [r, g, b, 1.0];
                }
            }
        }
    }
    Picture { width: whole.0, height: whole.1, rgba, depth: Vec::new() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_are_shrunk_and_laid_out_with_gaps_where_there_is_none() {
        // 640 × 4 pixels, red on the left half and white on the right one.
        let pixels = (0..4).flat_map(|_| (0..640).flat_map(|x| if x < 320 { [1.0, 0.0, 0.0] } else { [1.0; 3] }));
        let tile = Tile::of(640, 4, &pixels.collect::<Vec<_>>());
        assert_eq!((tile.width, tile.height), (320, 2));
        let sheet = side_by_side(&[vec![Some(tile.clone()), None], vec![None, Some(tile)]]);
        assert_eq!((sheet.width, sheet.height), (640, 4));
        let at = |x: usize, y: usize| sheet.rgba[y * sheet.width + x];
        assert_eq!((at(0, 0), at(319, 1)), ([1.0, 0.0, 0.0, 1.0], [1.0; 4]));
        assert_eq!((at(320, 0), at(0, 2), at(320, 3)), (NOTHING, NOTHING, [1.0, 0.0, 0.0, 1.0]));
    }

    #[test]
    fn a_sheet_without_pictures_is_empty() {
        assert!(side_by_side(&[vec![None]]).rgba.is_empty());
    }
}
