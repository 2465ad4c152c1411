//! By-products as files, read back byte by byte.

use std::path::Path;

use cosplat_viewer::{Form, Layers, NO_OBJECT, Picture, Plane};

/// Two pixels: one in which something is seen, and one in which nothing is.
fn layers() -> Layers {
    let rgba = vec![[0.1, 0.2, 0.3, 0.5], [0.0; 4]];
    let picture = Picture { width: 2, height: 1, rgba, depth: vec![1.2345, f32::INFINITY] };
    Layers {
        picture,
        normal: vec![[0.28, 0.96, 0.0], [0.0; 3]],
        object: vec![2, NO_OBJECT],
        flow: vec![[1.5, -0.25], [f32::NAN; 2]],
    }
}

/// Words of a PNG, and how many are a pixel.
fn words(plane: Plane) -> (Vec<u16>, usize) {
    let bytes = layers().encode(plane, Form::Png).expect("it can be stored");
    let mut decoder = png::Decoder::new(std::io::Cursor::new(bytes));
    decoder.set_transformations(png::Transformations::IDENTITY);
    let mut reader = decoder.read_info().expect("a PNG");
    let mut data = vec![0; reader.output_buffer_size().expect("a size")];
    let info = reader.next_frame(&mut data).expect("a picture");
    assert_eq!((info.width, info.height, info.bit_depth), (2, 1, png::BitDepth::Sixteen));
    let words: Vec<u16> = data.as_chunks::<2>().0.iter().map(|b| u16::from_be_bytes(*b)).collect();
    let each = words.len() / 2;
    (words, each)
}

#[test]
fn pictures_of_sixteen_bits() {
    assert_eq!(words(Plane::Alpha), (vec![32_768, 0], 1));
    // Thousandths of a unit, rounded.
    assert_eq!(words(Plane::Depth), (vec![1235, 0], 1));
    assert_eq!(words(Plane::Object), (vec![3, 0], 1));
    // (n + 1) / 2 · 65535.
    assert_eq!(words(Plane::Normal), (vec![41_942, 64_224, 32_768, 0, 0, 0], 3));
    // 64 · pixels + 32768, and whether there is a flow.
    assert_eq!(words(Plane::Flow), (vec![32_864, 32_752, 1, 0, 0, 0], 3));
}

#[test]
fn a_flo_is_that_of_middlebury() {
    let bytes = layers().encode(Plane::Flow, Form::Flo).unwrap();
    assert_eq!(&bytes[..4], b"PIEH");
    let number = |i: usize| f32::from_le_bytes(bytes[4 * i..4 * i + 4].try_into().expect("four bytes"));
    assert_eq!(bytes[4..12], [2, 0, 0, 0, 1, 0, 0, 0]);
    assert_eq!([3, 4, 5, 6].map(|i| number(i).to_bits()), [1.5_f32, -0.25, 1e10, 1e10].map(f32::to_bits));
    assert_eq!(bytes.len(), 28);
}

#[test]
fn arrays_are_those_of_numpy() {
    for (plane, kind, shape, count) in [
        (Plane::Alpha, "<f4", "(1, 2,)", 2),
        (Plane::Depth, "<f4", "(1, 2,)", 2),
        (Plane::Normal, "<f4", "(1, 2, 3)", 6),
        (Plane::Flow, "<f4", "(1, 2, 2)", 4),
        (Plane::Object, "<u4", "(1, 2,)", 2),
    ] {
        let bytes = layers().encode(plane, Form::Npy).unwrap();
        assert_eq!(&bytes[..8], b"\x93NUMPY\x01\x00");
        let length = usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
        let header = std::str::from_utf8(&bytes[10..10 + length]).unwrap();
        assert!((10 + length) % 64 == 0 && header.ends_with('\n'), "{header:?}");
        let dictionary = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}");
        assert_eq!(header.trim_end(), dictionary);
        assert_eq!(bytes.len() - 10 - length, 4 * count);
    }
    let depth = layers().encode(Plane::Depth, Form::Npy).unwrap();
    assert!(depth.ends_with(&[1.2345_f32.to_le_bytes(), f32::INFINITY.to_le_bytes()].concat()));
    assert!(layers().encode(Plane::Object, Form::Npy).unwrap().ends_with(&[2, 0, 0, 0, 255, 255, 255, 255]));
}

#[test]
fn what_cannot_be_stored_is_refused() {
    assert!(layers().encode(Plane::Depth, Form::Flo).unwrap_err().to_string().contains(".npy"));
    let still = Layers { flow: Vec::new(), ..layers() };
    assert!(still.encode(Plane::Flow, Form::Npy).unwrap_err().to_string().contains("next moment"));
    assert_eq!(Form::of(Path::new("a/b.FLO"), Plane::Flow).unwrap(), Form::Flo);
    assert!(Form::of(Path::new("b.flo"), Plane::Depth).is_err() && Form::of(Path::new("b"), Plane::Flow).is_err());
}
