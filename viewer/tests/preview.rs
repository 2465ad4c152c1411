//! Animated previews, read back frame by frame as a player would.

use cosplat_viewer::{Picture, Preview, PreviewError, PreviewOptions};

fn empty(width: usize, height: usize) -> Picture {
    Picture { width, height, rgba: vec![[0.0; 4]; width * height], depth: Vec::new() }
}

/// A bright square of 4 × 4 pixels, `step` pixels from the left, on a grey ground.
fn picture(step: usize) -> Picture {
    let mut picture = empty(40, 24);
    for y in 0..24 {
        for x in 0..40 {
            let inside = (8..12).contains(&y) && (step..step + 4).contains(&x);
            picture.rgba[y * 40 + x] = if inside { [1.0, 0.5, 0.25, 1.0] } else { [0.2, 0.2, 0.2, 0.0] };
        }
    }
    picture
}

fn preview(options: PreviewOptions, pictures: usize) -> Preview {
    let mut preview = Preview::new(options);
    (0..pictures).for_each(|i| preview.push(&picture(i % 30)).expect("one size"));
    preview
}

/// What a player would show, frame by frame, with the delay of the last frame in seconds.
fn play(bytes: &[u8]) -> (Vec<Vec<u8>>, f64) {
    let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().expect("a header");
    let (width, height) = (reader.info().width as usize, reader.info().height as usize);
    let frames = reader.info().animation_control().expect("an animation").num_frames;
    let (mut canvas, mut shown, mut delay) = (vec![0; width * height * 3], Vec::new(), 0.0);
    for _ in 0..frames {
        let mut buffer = vec![0; reader.output_buffer_size().expect("a size")];
        reader.next_frame(&mut buffer).expect("a frame");
        let control = *reader.info().frame_control().expect("a place");
        delay = f64::from(control.delay_num) / f64::from(control.delay_den);
        let (w, left, top) = (control.width as usize, control.x_offset as usize, control.y_offset as usize);
        for (i, pixel) in buffer.chunks_exact(4).take(w * control.height as usize).enumerate() {
            let at = ((top + i / w) * width + left + i % w) * 3;
            if pixel[3] == 255 {
                canvas[at..at + 3].copy_from_slice(&pixel[..3]);
            }
        }
        shown.push(canvas.clone());
    }
    (shown, delay)
}

#[test]
fn a_player_shows_the_pictures_that_were_given() {
    let preview = preview(PreviewOptions::default(), 5);
    let bytes = preview.encode().unwrap();
    let (shown, delay) = play(&bytes);
    assert_eq!(shown, (0..5).map(|i| picture(i).to_srgb8()).collect::<Vec<_>>());
    assert!((delay - 0.04).abs() < 1e-12);
    assert_eq!(bytes, preview.encode().unwrap());
}

#[test]
fn pictures_that_do_not_change_cost_next_to_nothing() {
    let size = |pictures: usize| {
        let mut preview = Preview::new(PreviewOptions::default());
        (0..pictures).for_each(|_| preview.push(&picture(3)).unwrap());
        let bytes = preview.encode().unwrap();
        assert_eq!(play(&bytes).0, vec![picture(3).to_srgb8(); pictures]);
        bytes.len()
    };
    // The control chunk of a frame has 38 bytes, a pixel's data chunk less than twice that.
    assert!(size(10) < size(1) + 9 * 120, "{} {}", size(10), size(1));
}

#[test]
fn too_many_pictures_are_thinned_and_keep_their_pace() {
    let options = PreviewOptions { frames: 8, ..PreviewOptions::default() };
    let preview = preview(options, 20);
    let (shown, delay) = play(&preview.encode().unwrap());
    let kept: Vec<_> = (0..20).step_by(4).map(|i| picture(i).to_srgb8()).collect();
    assert_eq!((shown, preview.frames()), (kept, 5));
    assert!((delay - 4.0 / 25.0).abs() < 1e-12);
}

#[test]
fn a_file_keeps_its_largest_size() {
    let whole = preview(PreviewOptions::default(), 30).encode().unwrap();
    let bytes = whole.len() / 2;
    let small = preview(PreviewOptions { bytes, ..PreviewOptions::default() }, 30).encode().unwrap();
    assert!(small.len() <= bytes && play(&small).0.len() >= 2);
    let least = preview(PreviewOptions { bytes: 0, ..PreviewOptions::default() }, 30).encode().unwrap();
    assert_eq!(play(&least).0.len(), 1);
}

#[test]
fn shrunk_pictures_hold_the_means_of_squares() {
    let options = PreviewOptions { largest_px: 20, ..PreviewOptions::default() };
    let shown = play(&preview(options, 2).encode().unwrap()).0;
    let pixel = |frame: usize, x: usize, y: usize| shown[frame][(y * 20 + x) * 3];
    assert_eq!((shown[0].len(), pixel(0, 0, 4), pixel(0, 2, 4)), (20 * 12 * 3, 255, 51));
    // Half of the square is bright in the second picture, (255 + 51) / 2.
    assert_eq!((pixel(1, 0, 4), pixel(1, 2, 4)), (153, 153));
}

#[test]
fn bad_previews_are_refused() {
    let mut preview = preview(PreviewOptions::default(), 1);
    assert!(matches!(preview.push(&empty(3, 3)), Err(PreviewError::Size(3, 3, 40, 24))));
    assert!(matches!(Preview::new(PreviewOptions::default()).encode(), Err(PreviewError::Empty)));
    // Bounds of zero are taken as one.
    let zero = PreviewOptions { pictures_per_second: 0, largest_px: 0, frames: 0, bytes: 0, plays: 0 };
    let mut least = Preview::new(zero);
    (0..5).for_each(|i| least.push(&picture(i)).unwrap());
    assert_eq!(play(&least.encode().unwrap()).0.len(), 1);
}
