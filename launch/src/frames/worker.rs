//! The thread that turns frames into files.

use std::fs::{self, File};
use std::io::ErrorKind;
use std::path::Path;
use std::sync::Arc;
use std::sync::mpsc::Receiver;
use std::time::Instant;

use cosplat_core::visual::VisualFrame;
use cosplat_splat::{OutputFrame, Splats, merge};
use cosplat_viewer::gpu::Renderer;
use cosplat_viewer::recording::Recording;
use cosplat_viewer::{Camera, Gaussians, Picture, Preview, PreviewOptions, png};
use nalgebra::Vector3;

use super::Order;
use super::body::{Look, Player, borrowed};
use super::conditions::{Conditions, lost_at};
use super::files::{Frames, Wanted, picture};
use super::film::film;
use super::live::Live;
use super::moment::Item;
use super::rows::Sums;
use super::sequence::Sequence;
use super::stage::{Stage, options, renderer};
use super::surfaces::Surfaces;
use crate::folder::{CONDITIONS, PICTURES, PREVIEW, SPLATS, SURFACES};

/// Everything that turns frames into files.
pub(super) struct Worker {
    wanted: Wanted,
    recording: Option<Recording>,
    live: Option<Live>,
    renderer: Renderer,
    conditions: Option<Conditions>,
    preview: Preview,
    sequence: Sequence,
    surfaces: Option<Surfaces>,
    sums: Sums,
    done: Frames,
    /// Whether this life of the run has recorded anything.
    has_recorded: bool,
    /// Files that may not be on disk yet.
    unsynced: Vec<String>,
}

impl Worker {
    /// Makes the folders and opens the recording.
    pub(super) fn new(wanted: Wanted) -> Result<Self, String> {
        let output = &wanted.output;
        let renderer = renderer(output)?;
        let folders = [
            (PICTURES, output.pictures),
            (CONDITIONS, output.preset.is_some()),
            (SPLATS, output.splats),
            (SURFACES, output.surfaces.is_some()),
        ];
        for (folder, is_wanted) in folders {
            if is_wanted {
                make_folder(&wanted.folder.join(folder))?;
            }
        }
        let stage = Stage::new(&wanted);
        let place = wanted.folder.join(&wanted.recording);
        let recording = output.recording.then(|| Recording::create(&place, &stage.layout()));
        let recording = recording.transpose().map_err(|e| e.to_string())?;
        let live = wanted.live.map(|to| Live::start(to, stage)).transpose()?;
        let preview = Preview::new(PreviewOptions {
            pictures_per_second: wanted.frames_per_second.round().clamp(1.0, 100.0) as u16,
            ..PreviewOptions::default()
        });
        let surfaces = wanted.output.surfaces;
        let surfaces = surfaces.map(|form| Surfaces::new(wanted.folder.clone(), form, wanted.liquids.clone()));
        Ok(Self {
            surfaces,
            sequence: Sequence::new(&wanted.folder, output.splat_form),
            wanted,
            recording,
            live,
            renderer,
            conditions: None,
            preview,
            sums: Sums::default(),
            done: Frames::default(),
            has_recorded: false,
            unsynced: Vec::new(),
        })
    }

    /// Takes frames until there are no more.
    pub(super) fn work(mut self, orders: &Receiver<Order>) -> Result<Frames, String> {
        let drawn = std::mem::take(&mut self.wanted.drawn);
        // Files keep the frame of the first capture, so that what did not move has the bits it came with.
        let first = drawn.iter().find_map(|d| match &d.look {
            Look::Capture(staged) => Some(OutputFrame::of_file(staged, &d.pose)),
            _ => None,
        });
        let frame = first.unwrap_or_else(OutputFrame::world);
        let metres_per_unit = frame.from_world.inverse().scale;
        let preset = self.wanted.output.preset;
        self.conditions = preset.map(|_| Conditions::new(&self.wanted.folder, metres_per_unit));
        let turns = self.wanted.output.turn_colours;
        let mut players: Vec<Player<'_>> = drawn.iter().map(|d| Player::new(d, frame, turns)).collect();
        for order in orders {
            let visual = match order {
                Order::Take(visual) => visual,
                Order::Open(first, taken) => {
                    follow(&mut players, &first)?;
                    self.take_over(taken)?;
                    continue;
                }
                Order::Flush(say) => {
                    self.sync()?;
                    // Who asked may be gone with the run.
                    let _ = say.send(());
                    continue;
                }
            };
            self.take_rows()?;
            let began = Instant::now();
            follow(&mut players, &visual)?;
            self.done.skin_s += began.elapsed().as_secs_f64();
            self.draw(&players, &frame, &visual)?;
            self.write(&players, visual.number)?;
            self.write_surfaces(&visual)?;
            self.record(&players, &visual)?;
            self.done.taken += 1;
        }
        if let (Some(conditions), Some(preset)) = (&mut self.conditions, preset) {
            let options = options(&self.wanted.output);
            let per_second = self.wanted.frames_per_second;
            conditions.finish(&mut self.renderer, &options, preset, per_second, &players)?;
        }
        self.finish()
    }

    /// Counts the frames of earlier lives of the run as if they had been made here.
    fn take_over(&mut self, taken: u64) -> Result<(), String> {
        for number in 0..taken {
            if self.wanted.output.pictures {
                let name = picture(number);
                let (width, height, values) = png::read(&self.wanted.folder.join(&name)).map_err(|e| e.to_string())?;
                let rgba = values.as_chunks::<3>().0.iter().map(|&[r, g, b]| [r, g, b, 1.0]).collect();
                let drawn = Picture { width, height, rgba, depth: Vec::new() };
                self.preview.push(&drawn).map_err(|e| e.to_string())?;
                self.done.pictures.push(name);
            }
        }
        if self.wanted.output.splats {
            self.done.splats = self.sequence.take_over(taken)?;
        }
        self.done.surfaces = self.surfaces.as_ref().map(|s| s.of_earlier(taken)).unwrap_or_default();
        self.done.left_out.extend(self.conditions.as_ref().and_then(|_| lost_at(taken)));
        self.done.taken = taken;
        Ok(())
    }

    /// Waits until all pictures and splat files are on disk.
    fn sync(&mut self) -> Result<(), String> {
        for name in self.unsynced.drain(..) {
            let path = self.wanted.folder.join(&name);
            let synced = File::open(&path).and_then(|file| file.sync_all());
            synced.map_err(|e| format!("cannot write `{}`: {e}", path.display()))?;
        }
        Ok(())
    }

    fn note(&mut self, name: &str) {
        if self.wanted.is_kept {
            self.unsynced.push(name.to_owned());
        }
    }

    fn draw(&mut self, players: &[Player<'_>], frame: &OutputFrame, visual: &VisualFrame) -> Result<(), String> {
        if !self.wanted.output.pictures {
            return Ok(());
        }
        let began = Instant::now();
        let view = seen_from(&self.wanted.shot.at(visual.time_s), frame).view().map_err(|e| e.to_string())?;
        let sets: Vec<Gaussians<'_>> = players.iter().map(|p| borrowed(&p.splats)).collect();
        let options = options(&self.wanted.output);
        let drawn = self.renderer.render(&sets, &view, &options).map_err(|e| e.to_string())?;
        let name = picture(visual.number);
        png::write(&self.wanted.folder.join(&name), &drawn).map_err(|e| e.to_string())?;
        self.preview.push(&drawn).map_err(|e| e.to_string())?;
        self.note(&name);
        self.done.pictures.push(name);
        if let Some(conditions) = &mut self.conditions {
            conditions.take(&mut self.renderer, &options, (visual.number, view), players)?;
        }
        self.done.draw_s += began.elapsed().as_secs_f64();
        Ok(())
    }

    fn write(&mut self, players: &[Player<'_>], number: u64) -> Result<(), String> {
        if !self.wanted.output.splats {
            return Ok(());
        }
        let began = Instant::now();
        let sets: Vec<&Splats> = players.iter().map(|p| &p.splats).collect();
        let name = self.sequence.write(number, &merge(&sets).map_err(|e| e.to_string())?)?;
        self.note(&name);
        self.done.splats.push(name);
        self.done.write_s += began.elapsed().as_secs_f64();
        Ok(())
    }

    fn write_surfaces(&mut self, visual: &VisualFrame) -> Result<(), String> {
        let Some(surfaces) = &self.surfaces else { return Ok(()) };
        let began = Instant::now();
        let names = surfaces.write(visual)?;
        for name in &names {
            self.note(name);
        }
        self.done.surfaces.extend(names);
        self.done.write_s += began.elapsed().as_secs_f64();
        Ok(())
    }

    fn record(&mut self, players: &[Player<'_>], visual: &VisualFrame) -> Result<(), String> {
        if self.recording.is_none() && self.live.is_none() {
            return Ok(());
        }
        let began = Instant::now();
        let is_first = !std::mem::replace(&mut self.has_recorded, true);
        let impulses = self.sums.take().into_iter();
        let impulses = impulses.map(|(name, at, j)| (format!("world/impulse/{name}"), Item::Impulse(at, j)));
        let seen = players.iter().flat_map(|p| p.items(is_first));
        let items: Vec<(String, Arc<Item>)> = seen.chain(impulses).map(|(name, item)| (name, Arc::new(item))).collect();
        let window = visual.number * self.wanted.windows_per_frame;
        if let Some(live) = &self.live {
            live.frame(window, visual.time_s, &items);
        }
        if let Some(recording) = &mut self.recording {
            recording.frame(window, visual.time_s);
            let mut each = items.iter();
            let put = each.try_for_each(|(entity, item)| item.put(recording, entity, usize::MAX));
            put.and_then(|()| recording.flush()).map_err(|e| e.to_string())?;
        }
        self.done.record_s += began.elapsed().as_secs_f64();
        Ok(())
    }

    /// Takes what has been settled by now.
    fn take_rows(&mut self) -> Result<(), String> {
        while let Ok(row) = self.wanted.rows.try_recv() {
            let row = Arc::new(row);
            if let Some(recording) = &mut self.recording {
                row.put(recording).map_err(|e| e.to_string())?;
            }
            if let Some(live) = &self.live {
                live.row(&row);
            }
            self.sums.add(&row.impulses);
        }
        Ok(())
    }

    fn finish(mut self) -> Result<Frames, String> {
        self.take_rows()?;
        if self.preview.frames() > 0 {
            self.preview.write(&self.wanted.folder.join(PREVIEW)).map_err(|e| e.to_string())?;
        }
        if let Some(recording) = self.recording {
            recording.finish().map_err(|e| e.to_string())?;
        }
        if self.wanted.output.video && !self.done.pictures.is_empty() {
            match film(&self.wanted.folder, self.wanted.frames_per_second) {
                Ok(()) => self.done.has_film = true,
                Err(left_out) => self.done.left_out.push(left_out),
            }
        }
        if let Some(live) = self.live {
            live.finish();
        }
        self.done.left_out.extend(self.surfaces.as_ref().and_then(Surfaces::left_out));
        self.done.drawn_by = self.renderer.why().to_owned();
        Ok(self.done)
    }
}

fn follow(players: &mut [Player<'_>], visual: &VisualFrame) -> Result<(), String> {
    for (name, state) in &visual.bodies {
        let player = players.iter_mut().find(|p| p.name() == name);
        player.ok_or_else(|| format!("body `{name}` was not prepared to be drawn"))?.follow(state)?;
    }
    Ok(())
}

/// Makes an empty folder; one of an earlier run has been removed.
fn make_folder(path: &Path) -> Result<(), String> {
    match fs::create_dir(path) {
        Err(e) if e.kind() != ErrorKind::AlreadyExists => Err(format!("cannot create `{}`: {e}", path.display())),
        _ => Ok(()),
    }
}

/// The same camera in another frame.
fn seen_from(camera: &Camera, frame: &OutputFrame) -> Camera {
    let point = |p: [f64; 3]| frame.from_world.point(Vector3::from(p)).into();
    let up = (frame.from_world.rotation * Vector3::from(camera.up)).into();
    Camera { eye: point(camera.eye), target: point(camera.target), up, ..*camera }
}
