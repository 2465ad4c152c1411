//! Triangle meshes: files, oriented surface samples, signed distance.
