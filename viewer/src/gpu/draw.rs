//! The steps of one picture.

use wgpu::{Buffer, CommandEncoder};

use crate::camera::View;
use crate::gaussians::Gaussians;
use crate::layers::{Layers, Next, Pixel};
use crate::picture::Picture;
use crate::render::Options;
use crate::tiles::TILE;

use super::device::{Gpu, GpuError};
use super::kernels::{groups, record};
use super::pack::{group, shapes};
use super::sort::Pairs;

/// Items that a work group of most kernels takes.
const WIDE: u64 = 256;
/// Numbers of an ellipse, a feature, a pixel and its by-products.
const ELLIPSE: u64 = 12;
const FEATURE: u64 = 8;
const COLOURS: u64 = 4;
const SUMS: u64 = 8;

/// What comes back: four numbers a pixel, and eight where by-products are asked for.
struct Drawn {
    rgba: Vec<u32>,
    beside: Vec<u32>,
}

/// Projected Gaussians.
struct Projected {
    ellipses: Buffer,
    boxes: Buffer,
    features: Buffer,
    depths: Pairs,
}

/// Places of ellipses in tiles.
struct Lists {
    lists: Buffer,
    ranges: Buffer,
}

impl Gpu {
    /// Draws all sets as one, as [`crate::render`] does.
    ///
    /// # Errors
    /// Too much for the device, or it failed.
    ///
    /// # Panics
    /// A set for which [`Gaussians::check`] fails.
    pub fn render(&self, sets: &[Gaussians<'_>], view: &View, options: &Options) -> Result<Picture, GpuError> {
        let drawn = self.draw(sets, view, options, None, options.depth)?;
        let depth = pixels(&drawn).map(|p| p.depth).collect();
        Ok(Picture { width: view.width, height: view.height, rgba: colours(&drawn), depth })
    }

    /// Draws all sets and the by-products, as [`crate::render_layers`] does.
    ///
    /// # Errors
    /// The next moment is not one of these sets, it is too much for the device, or that failed.
    ///
    /// # Panics
    /// A set for which [`Gaussians::check`] fails.
    pub fn render_layers(
        &self,
        sets: &[Gaussians<'_>],
        view: &View,
        options: &Options,
        next: Option<&Next<'_>>,
    ) -> Result<Layers, GpuError> {
        if let Some(next) = next {
            next.check(sets)?;
        }
        let drawn = self.draw(sets, view, options, next, true)?;
        let pixels: Vec<Pixel> = pixels(&drawn).collect();
        Ok(Layers::new(view, colours(&drawn), &pixels, next.is_some()))
    }

    fn draw(
        &self,
        sets: &[Gaussians<'_>],
        view: &View,
        options: &Options,
        next: Option<&Next<'_>>,
        has_features: bool,
    ) -> Result<Drawn, GpuError> {
        let count: u64 = sets.iter().map(|s| s.positions.len() as u64).sum();
        let mut encoder = self.encoder();
        let projected = self.project(&mut encoder, sets, view, options, next, has_features)?;
        let Projected { ellipses, boxes, features, depths } = projected;
        let order = self.sort(&mut encoder, depths, count, u32::BITS)?.values;
        let (lists, mut encoder) = self.bin(encoder, &order, &boxes, count, view)?;
        let pixels = (view.width * view.height) as u64;
        let rgba = self.zeros("the pixels of the picture", COLOURS * pixels)?;
        let beside = self.zeros("the by-products of the picture", if has_features { SUMS * pixels } else { 0 })?;
        let [red, green, blue] = options.background.map(f32::to_bits);
        let (width, height) = (view.width as u32, view.height as u32);
        let floor = (options.kernel_floor as f32).to_bits();
        let about = [red, green, blue, 0, width, height, u32::from(has_features), floor];
        let about = self.filled("blend", bytemuck::cast_slice(&about))?;
        let buffers = [
            (0, &about),
            (1, &ellipses),
            (2, &features),
            (3, &lists.lists),
            (4, &lists.ranges),
            (5, &rgba),
            (6, &beside),
        ];
        let tile = TILE as u32;
        let tiles = [width.div_ceil(tile), height.div_ceil(tile)];
        record(&self.device, &mut encoder, &self.kernels.draw, &buffers, tiles);
        let wanted = [&rgba, &beside];
        let mut read = self.finish(encoder, &wanted[..=usize::from(has_features)])?.into_iter();
        Ok(Drawn { rgba: read.next().unwrap_or_default(), beside: read.next().unwrap_or_default() })
    }

    fn encoder(&self) -> CommandEncoder {
        self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default())
    }

    fn project(
        &self,
        encoder: &mut CommandEncoder,
        sets: &[Gaussians<'_>],
        view: &View,
        options: &Options,
        next: Option<&Next<'_>>,
        has_features: bool,
    ) -> Result<Projected, GpuError> {
        let count: u64 = sets.iter().map(|s| s.positions.len() as u64).sum();
        let projected = Projected {
            ellipses: self.zeros("the ellipses", ELLIPSE * count)?,
            boxes: self.zeros("the boxes of the ellipses", 2 * count)?,
            features: self.zeros("the by-products of the Gaussians", if has_features { FEATURE * count } else { 0 })?,
            depths: Pairs { keys: self.zeros("the depths", count)?, values: self.zeros("the order", count)? },
        };
        let mut first = 0;
        for (object, set) in sets.iter().enumerate() {
            let there = next.map(|next| (next.positions[object], &next.view));
            let shapes = self.filled("the Gaussians", bytemuck::cast_slice(&shapes(set, view, there)))?;
            let bands = self.filled("the colours", bytemuck::cast_slice(set.sh_rest))?;
            let about = group(set, [first, object as u32], view, options, next, has_features);
            let about = self.filled("group", bytemuck::cast_slice(&about))?;
            let buffers = [
                (0, &about),
                (1, &shapes),
                (2, &bands),
                (3, &projected.ellipses),
                (4, &projected.boxes),
                (5, &projected.depths.keys),
                (6, &projected.depths.values),
                (7, &projected.features),
            ];
            let size = groups(set.positions.len() as u64, WIDE);
            record(&self.device, encoder, &self.kernels.project, &buffers, size);
            first += set.positions.len() as u32;
        }
        Ok(projected)
    }

    /// Makes the list of every tile. How long all lists are together is only known on the device, so what was recorded
    /// runs here, and a new recording comes back.
    fn bin(
        &self,
        mut encoder: CommandEncoder,
        order: &Buffer,
        boxes: &Buffer,
        count: u64,
        view: &View,
    ) -> Result<(Lists, CommandEncoder), GpuError> {
        let (device, kernels) = (&self.device, &self.kernels);
        let (across, down) = (view.width.div_ceil(TILE) as u64, view.height.div_ceil(TILE) as u64);
        let starts = self.zeros("the starts of lists", count)?;
        let total = self.zeros("total", 2)?;
        let about = self.filled("bin", bytemuck::cast_slice(&[count as u32, 0, across as u32, 0]))?;
        let counted = [(0, &about), (1, order), (2, boxes), (3, &starts), (4, &total)];
        record(device, &mut encoder, &kernels.count_tiles, &counted, groups(count, WIDE));
        self.sum_before(&mut encoder, &starts, count)?;
        let read = self.finish(encoder, &[&total])?;
        let listed = read.first().map_or(0, |t| u64::from(t[0]) | u64::from(t[1]) << 32);

        let mut encoder = self.encoder();
        let pairs = Pairs {
            keys: self.zeros("the lists of the tiles", listed)?,
            values: self.zeros("the lists of the tiles", listed)?,
        };
        let about = self.filled("bin", bytemuck::cast_slice(&[count as u32, listed as u32, across as u32, 0]))?;
        let made = [(0, &about), (1, order), (2, boxes), (3, &starts), (5, &pairs.keys), (6, &pairs.values)];
        record(device, &mut encoder, &kernels.list_tiles, &made, groups(count, WIDE));
        let bits = u64::BITS - (across * down).leading_zeros();
        let sorted = self.sort(&mut encoder, pairs, listed, bits)?;
        let ranges = self.zeros("the ranges of the tiles", 2 * across * down)?;
        let found = [(0, &about), (5, &sorted.keys), (7, &ranges)];
        record(device, &mut encoder, &kernels.find_ranges, &found, groups(listed, WIDE));
        Ok((Lists { lists: sorted.values, ranges }, encoder))
    }
}

fn colours(drawn: &Drawn) -> Vec<[f32; 4]> {
    drawn.rgba.as_chunks::<4>().0.iter().map(|pixel| pixel.map(f32::from_bits)).collect()
}

/// By-products, none where they were not asked for.
fn pixels(drawn: &Drawn) -> impl Iterator<Item = Pixel> {
    let pairs = drawn.beside.as_chunks::<8>().0.iter().zip(drawn.rgba.as_chunks::<4>().0);
    pairs.map(|(sums, colour)| {
        let [x, y, z, depth, along, down, moving, _] = sums.map(f32::from_bits);
        Pixel::of_sums(f32::from_bits(colour[3]), depth, [x, y, z], sums[7], [along, down, moving])
    })
}
