//! An object that comes in pieces: an asset on its way in.

use super::{ObjectError, Objects, failed};
use axum::body::Bytes;
use object_store::path::Path;
use object_store::{MultipartUpload, ObjectStoreExt, PutPayload};

/// Bytes of one part: S3 takes no smaller ones, but for the last. Each upload
/// under way holds so many.
const PART_BYTES: usize = 5 << 20;

/// An object under way. Nothing of it is visible before [`Upload::complete`].
pub struct Upload {
    name: String,
    objects: Objects,
    /// Begun with the second part: what fits into one is written at once.
    parts: Option<Box<dyn MultipartUpload>>,
    waiting: Vec<Bytes>,
    waiting_bytes: usize,
}

impl std::fmt::Debug for Upload {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Upload").field("name", &self.name).finish()
    }
}

impl Objects {
    /// Begin an object that comes in pieces.
    #[must_use]
    pub fn upload(&self, name: &str) -> Upload {
        Upload {
            name: name.to_owned(),
            objects: self.clone(),
            parts: None,
            waiting: Vec::new(),
            waiting_bytes: 0,
        }
    }
}

impl Upload {
    /// Take the next piece.
    ///
    /// # Errors
    /// The store failed; the upload should be given up.
    pub async fn put(&mut self, mut piece: Bytes) -> Result<(), ObjectError> {
        // Parts of one size: some stores take no others.
        while self.waiting_bytes + piece.len() > PART_BYTES {
            let head = piece.split_to(PART_BYTES - self.waiting_bytes);
            self.hold(head);
            self.flush().await?;
        }
        self.hold(piece);
        Ok(())
    }

    fn hold(&mut self, piece: Bytes) {
        self.waiting_bytes += piece.len();
        self.waiting.push(piece);
    }

    async fn flush(&mut self) -> Result<(), ObjectError> {
        let parts = match &mut self.parts {
            Some(parts) => parts,
            none => {
                let path = Path::from(&*self.name);
                let begun = self.objects.store.put_multipart(&path).await;
                none.insert(begun.map_err(|e| self.objects.failed(&self.name, e))?)
            }
        };
        let payload = std::mem::take(&mut self.waiting);
        self.waiting_bytes = 0;
        let put = parts.put_part(PutPayload::from_iter(payload)).await;
        put.map_err(|e| self.objects.failed(&self.name, e))
    }

    /// Make the object visible, durably, in the place of one of the same name.
    ///
    /// # Errors
    /// The store failed; the object is as before.
    pub async fn complete(mut self) -> Result<(), ObjectError> {
        if self.parts.is_some() && self.waiting_bytes > 0 {
            self.flush().await?;
        }
        let done = match &mut self.parts {
            Some(parts) => parts.complete().await,
            None => {
                let payload = PutPayload::from_iter(std::mem::take(&mut self.waiting));
                let name = Path::from(&*self.name);
                self.objects.store.put(&name, payload).await
            }
        };
        done.map(|_| ())
            .map_err(|e| self.objects.failed(&self.name, e))
    }

    /// Give it up.
    ///
    /// # Errors
    /// The store failed: parts stay until its own rules remove them.
    pub async fn abort(mut self) -> Result<(), ObjectError> {
        match &mut self.parts {
            Some(parts) => parts.abort().await.map_err(|e| failed(&self.name, e)),
            None => Ok(()),
        }
    }
}
