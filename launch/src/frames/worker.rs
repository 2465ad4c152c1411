//! The thread that turns frames into files.

use std::fs::{self, File};
use std::io::ErrorKind;
use std::path::Path;
use std::sync::mpsc::Receiver;
use std::time::Instant;

use cosplat_core::visual::{VisualFrame, VisualState};
use cosplat_splat::{Axes, OutputFrame, Splats, format, merge};
use cosplat_viewer::recording::{Layout, Recording};
use cosplat_viewer::{Camera, Gaussians, Options, Picture, Preview, PreviewOptions, View, png, render};
use nalgebra::Vector3;

use super::Order;
use super::body::{Look, Player};
use super::files::{Frames, Wanted, picture, splats};
use super::rows::{CURVES, Sums};
use crate::folder::{PICTURES, PREVIEW, SPLATS};

/// Length of an arrow for an impulse \[m/(N s)\].
const ARROW: f64 = 0.2;
/// Radius of a boundary particle in a recording \[m\]; the viewer can show them larger.
const DOT_M: f32 = 0.001;
const DOT_COLOUR: [u8; 4] = [255, 160, 40, 255];

/// Everything that turns frames into files.
pub(super) struct Worker {
    wanted: Wanted,
    recording: Option<Recording>,
    preview: Preview,
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
        for (folder, is_wanted) in [(PICTURES, output.pictures), (SPLATS, output.splats)] {
            if is_wanted {
                make_folder(&wanted.folder.join(folder))?;
            }
        }
        let background = Options::default().with_linear_background(linear(output)).background;
        let layout = Layout {
            scene: &wanted.scene,
            run: &wanted.run,
            up: wanted.camera.up,
            camera: Some(&wanted.camera),
            background,
            curves: &CURVES,
        };
        let recording = output.recording.then(|| Recording::create(&wanted.folder.join(&wanted.recording), &layout));
        let recording = recording.transpose().map_err(|e| e.to_string())?;
        let preview = Preview::new(PreviewOptions {
            pictures_per_second: wanted.frames_per_second.round().clamp(1.0, 100.0) as u16,
            ..PreviewOptions::default()
        });
        Ok(Self {
            wanted,
            recording,
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
        let mut players: Vec<Player<'_>> = drawn.iter().map(|d| Player::new(d, frame)).collect();
        let view = seen_from(&self.wanted.camera, &frame).view().map_err(|e| e.to_string())?;
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
            self.draw(&players, &view, visual.number)?;
            self.write(&players, visual.number)?;
            self.record(&players, &frame, &visual)?;
            self.done.taken += 1;
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
            if self.wanted.output.splats {
                self.done.splats.push(splats(number));
            }
        }
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

    fn draw(&mut self, players: &[Player<'_>], view: &View, number: u64) -> Result<(), String> {
        if !self.wanted.output.pictures {
            return Ok(());
        }
        let began = Instant::now();
        let sets: Vec<Gaussians<'_>> = players.iter().map(|p| borrowed(&p.splats)).collect();
        let options = Options::default().with_linear_background(linear(&self.wanted.output));
        let drawn = render(&sets, view, &options);
        let name = picture(number);
        png::write(&self.wanted.folder.join(&name), &drawn).map_err(|e| e.to_string())?;
        self.preview.push(&drawn).map_err(|e| e.to_string())?;
        self.note(&name);
        self.done.pictures.push(name);
        self.done.draw_s += began.elapsed().as_secs_f64();
        Ok(())
    }

    fn write(&mut self, players: &[Player<'_>], number: u64) -> Result<(), String> {
        if !self.wanted.output.splats {
            return Ok(());
        }
        let began = Instant::now();
        let sets: Vec<&Splats> = players.iter().map(|p| &p.splats).collect();
        let all = merge(&sets).map_err(|e| e.to_string())?;
        let name = splats(number);
        format::write_file(&self.wanted.folder.join(&name), &all).map_err(|e| e.to_string())?;
        self.note(&name);
        self.done.splats.push(name);
        self.done.write_s += began.elapsed().as_secs_f64();
        Ok(())
    }

    fn record(&mut self, players: &[Player<'_>], frame: &OutputFrame, visual: &VisualFrame) -> Result<(), String> {
        let Some(recording) = &mut self.recording else { return Ok(()) };
        let is_first = !std::mem::replace(&mut self.has_recorded, true);
        let began = Instant::now();
        let to_world = frame.from_world.inverse();
        let mut add = || {
            recording.frame(visual.number * self.wanted.windows_per_frame, visual.time_s);
            for player in players.iter().filter(|p| p.has_moved || is_first) {
                let mut world = player.splats.clone();
                to_world.apply(&mut world, Axes::Scene);
                let entity = format!("world/{}", player.name());
                if player.is_still() {
                    recording.static_splats(&entity, &borrowed(&world))?;
                } else {
                    recording.splats(&entity, &borrowed(&world))?;
                }
            }
            for (name, state) in &visual.bodies {
                if let VisualState::Particles { position, .. } = state {
                    let points: Vec<[f32; 3]> = position.iter().map(|p| p.map(|v| v as f32)).collect();
                    recording.points(&format!("world/boundary/{name}"), &points, &[DOT_COLOUR], &[DOT_M])?;
                }
            }
            for (name, at, impulse) in self.sums.take() {
                recording.arrow(&format!("world/impulse/{name}"), at, impulse.map(|j| j * ARROW))?;
            }
            recording.flush()
        };
        add().map_err(|e| e.to_string())?;
        self.done.record_s += began.elapsed().as_secs_f64();
        Ok(())
    }

    /// Takes what has been settled by now.
    fn take_rows(&mut self) -> Result<(), String> {
        while let Ok(row) = self.wanted.rows.try_recv() {
            if let Some(recording) = &mut self.recording {
                let mut points = row.points.iter();
                let added = points.try_for_each(|(path, value)| recording.series(path, row.window, row.end_s, *value));
                added.map_err(|e| e.to_string())?;
            }
            self.sums.add(row.impulses);
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

fn linear(output: &cosplat_core::scene::OutputSpec) -> [f64; 3] {
    output.camera.as_ref().map_or([1.0; 3], |c| c.background)
}

fn borrowed(splats: &Splats) -> Gaussians<'_> {
    Gaussians {
        positions: &splats.positions,
        rotations: &splats.rotations,
        log_scales: &splats.log_scales,
        opacity_logits: &splats.opacity_logits,
        sh_dc: &splats.sh_dc,
        sh_rest: &splats.sh_rest,
        sh_degree: splats.sh_degree,
        antialiased: splats.antialiased,
    }
}

/// The same camera in another frame.
fn seen_from(camera: &Camera, frame: &OutputFrame) -> Camera {
    let point = |p: [f64; 3]| frame.from_world.point(Vector3::from(p)).into();
    let up = (frame.from_world.rotation * Vector3::from(camera.up)).into();
    Camera { eye: point(camera.eye), target: point(camera.target), up, ..*camera }
}
