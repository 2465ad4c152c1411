//! One primitive of points, each attribute in a buffer view of its own.

use serde_json::{Map, Value, json};

use super::{BIN, EXTENSION, FLOAT, JSON, MAGIC, attribute, coefficient};
use crate::clean::{Rules, clean};
use crate::splats::Splats;

/// Encodes the Gaussians whose numbers are all finite, because glTF has no others; [`crate::format::encode`] turns the
/// axes first.
pub(super) fn write(splats: &Splats) -> Vec<u8> {
    let (finite, report) = clean(splats, &Rules { opacity: 0.0, inside: None, largest_sigma: None });
    let selected = (report.kept < report.total).then(|| splats.select(&finite));
    let splats = selected.as_ref().unwrap_or(splats);
    let mut file = File { count: splats.len(), ..File::default() };
    let ends = |pick: fn(f32, f32) -> f32, from: f32| {
        splats.positions.iter().fold([from; 3], |e, p| [0, 1, 2].map(|k| pick(e[k], p[k])))
    };
    let ends = [ends(f32::min, f32::INFINITY), ends(f32::max, f32::NEG_INFINITY)];
    file.add("POSITION", splats.positions.iter().copied());
    if splats.is_empty() {
        file.accessors[0]["min"] = json!([0.0, 0.0, 0.0]);
    } else {
        (file.accessors[0]["min"], file.accessors[0]["max"]) = (json!(ends[0]), json!(ends[1]));
    }
    file.add(&attribute("ROTATION"), splats.rotations.iter().map(|q| unit(*q)));
    file.add(&attribute("SCALE"), splats.log_scales.iter().map(|s| s.map(|v| f64::from(v).exp() as f32)));
    file.add(&attribute("OPACITY"), (0..splats.len()).map(|i| [splats.opacity(i) as f32]));
    file.add(&coefficient(0), splats.sh_dc.iter().copied());
    for j in 0..splats.coefficients() {
        file.add(&coefficient(j + 1), (0..splats.len()).map(|i| splats.rest(i)[j]));
    }
    file.finish()
}

/// Quaternion w, x, y, z of any length as a unit one x, y, z, w; zero is no rotation.
fn unit(q: [f32; 4]) -> [f32; 4] {
    let q = q.map(f64::from);
    let length = q.iter().map(|v| v * v).sum::<f64>().sqrt();
    let [w, x, y, z] = if length > 0.0 { q.map(|v| (v / length) as f32) } else { [1.0, 0.0, 0.0, 0.0] };
    [x, y, z, w]
}

#[derive(Default)]
struct File {
    count: usize,
    bin: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
    attributes: Map<String, Value>,
}

impl File {
    fn add<const N: usize>(&mut self, name: &str, values: impl Iterator<Item = [f32; N]>) {
        let start = self.bin.len();
        values.flatten().for_each(|v| self.bin.extend_from_slice(&v.to_le_bytes()));
        let kind = ["", "SCALAR", "VEC2", "VEC3", "VEC4"][N];
        self.attributes.insert(name.to_owned(), json!(self.accessors.len()));
        self.accessors
            .push(json!({ "bufferView": self.views.len(), "componentType": FLOAT, "count": self.count, "type": kind }));
        self.views.push(json!({ "buffer": 0, "byteOffset": start, "byteLength": self.bin.len() - start }));
    }

    fn finish(self) -> Vec<u8> {
        let primitive = json!({
            "mode": 0,
            "attributes": self.attributes,
            "extensions": { EXTENSION: {
                "kernel": "ellipse",
                "colorSpace": "srgb_rec709_display",
                "projection": "perspective",
                "sortingMethod": "cameraDistance",
            } },
        });
        let document = json!({
            "asset": { "version": "2.0", "generator": "Cosplat" },
            "extensionsUsed": [EXTENSION],
            "scene": 0,
            "scenes": [{ "nodes": [0] }],
            "nodes": [{ "mesh": 0 }],
            "meshes": [{ "primitives": [primitive] }],
            "accessors": self.accessors,
            "bufferViews": self.views,
            "buffers": [{ "byteLength": self.bin.len() }],
        });
        let mut json = document.to_string().into_bytes();
        json.resize(json.len().next_multiple_of(4), b' ');
        let length = 12 + 8 + json.len() + 8 + self.bin.len();
        let mut out = Vec::with_capacity(length);
        out.extend_from_slice(MAGIC);
        let mut put = |v: u32| out.extend_from_slice(&v.to_le_bytes());
        put(2);
        // Lengths of the container have 32 bits; more than 17 million Gaussians of degree 3 do not fit.
        put(length as u32);
        put(json.len() as u32);
        put(JSON);
        out.extend_from_slice(&json);
        out.extend_from_slice(&(self.bin.len() as u32).to_le_bytes());
        out.extend_from_slice(&BIN.to_le_bytes());
        out.extend_from_slice(&self.bin);
        out
    }
}
