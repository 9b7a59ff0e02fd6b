//! Scenes on disk.

use std::path::Path;

use crate::compile::{CompiledWorld, compile};
use crate::text::Diagnostics;

/// Why a scene on disk gave no world.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// A file or folder cannot be read.
    #[error("{path}: {source}")]
    Read {
        /// The file or folder.
        path: String,
        /// Why.
        source: std::io::Error,
    },
    /// A folder holds no `.scene` files.
    #[error("{0}: there are no .scene files in this folder")]
    Empty(String),
    /// The scene has errors.
    #[error(transparent)]
    Scene(#[from] Diagnostics),
}

/// Compiles a scene file, or all `.scene` files of a folder in the order of their names.
///
/// # Errors
/// When nothing can be read there, or the scene has errors.
pub fn compile_scene_path(path: impl AsRef<Path>) -> Result<CompiledWorld, SceneError> {
    let path = path.as_ref();
    let named = |p: &Path| p.display().to_string();
    let failed = |p: &Path, source| SceneError::Read {
        path: named(p),
        source,
    };
    let mut files = Vec::new();
    if path.is_dir() {
        for entry in std::fs::read_dir(path).map_err(|e| failed(path, e))? {
            let file = entry.map_err(|e| failed(path, e))?.path();
            if file.extension().is_some_and(|e| e == "scene") {
                files.push(file);
            }
        }
        files.sort();
        if files.is_empty() {
            return Err(SceneError::Empty(named(path)));
        }
    } else {
        files.push(path.to_owned());
    }
    let mut texts = Vec::new();
    for file in files {
        let text = std::fs::read_to_string(&file).map_err(|e| failed(&file, e))?;
        texts.push((named(&file), text));
    }
    let texts: Vec<(&str, &str)> = texts
        .iter()
        .map(|(name, text)| (name.as_str(), text.as_str()))
        .collect();
    Ok(compile(&texts)?)
}
