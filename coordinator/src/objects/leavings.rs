//! What killed writers leave in a folder: files that were not yet in place, which
//! the object store does not list, and empty folders.

use super::{ObjectError, Objects, failed};
use object_store::Error;
use std::path::Path;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

/// Folders within folders: `part/<job>/<frame>/<tile>/<name>` has four.
const DEPTH_MAX: u32 = 8;

impl Objects {
    /// Remove unfinished files and empty folders that nobody has touched since
    /// `before_ms`; how many. An S3 store keeps unfinished uploads by its own rules.
    ///
    /// # Errors
    /// The folder cannot be read.
    pub async fn remove_leavings(&self, before_ms: i64) -> Result<u64, ObjectError> {
        let Some(folder) = self.folder.clone() else {
            return Ok(0);
        };
        let name = folder.display().to_string();
        let wrong = |source: Box<dyn std::error::Error + Send + Sync>| {
            failed(
                &name,
                Error::Generic {
                    store: "folder",
                    source,
                },
            )
        };
        let before = UNIX_EPOCH + Duration::from_millis(u64::try_from(before_ms).unwrap_or(0));
        let removed = tokio::task::spawn_blocking(move || {
            let mut removed = 0;
            clear(&folder, before, DEPTH_MAX, &mut removed).map(|()| removed)
        });
        removed
            .await
            .map_err(|e| wrong(e.into()))?
            .map_err(|e| wrong(e.into()))
    }
}

fn clear(folder: &Path, before: SystemTime, depth: u32, removed: &mut u64) -> std::io::Result<()> {
    if depth == 0 {
        return Ok(());
    }
    for entry in std::fs::read_dir(folder)? {
        let entry = entry?;
        // What vanishes meanwhile was removed by another.
        let Ok(meta) = entry.metadata() else { continue };
        let old = meta.modified().is_ok_and(|time| time < before);
        let path = entry.path();
        let gone = if meta.is_dir() {
            clear(&path, before, depth - 1, removed)?;
            // Refused unless it is empty. Its time is of before its last file went.
            old && std::fs::remove_dir(&path).is_ok()
        } else {
            let unfinished = entry.file_name().to_string_lossy().contains('#');
            old && unfinished && std::fs::remove_file(&path).is_ok()
        };
        *removed += u64::from(gone);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn unfinished_files_and_empty_folders_go() {
        let folder = tempfile::tempdir().expect("folder");
        let objects = Objects::local(folder.path()).expect("open");
        objects
            .put("part/1/0/0/x", b"x".to_vec())
            .await
            .expect("put");
        let at = |name: &str| folder.path().join(name);
        std::fs::write(at("part/1/0/0/y#1"), b"half").expect("write");
        std::fs::create_dir_all(at("part/2/0/0")).expect("folders");
        assert_eq!(
            objects.remove_leavings(0).await.expect("sweep"),
            0,
            "too new"
        );
        let soon = i64::MAX / 2;
        let removed = objects.remove_leavings(soon).await.expect("sweep");
        assert_eq!(removed, 4, "a file and three folders");
        assert!(at("part/1/0/0/x").exists() && !at("part/2").exists());
        objects
            .put("part/2/0/0/x", b"x".to_vec())
            .await
            .expect("put again");
    }
}
