//! Every limit of the system that both sides must agree on, with its reason.

/// Widest and highest picture, in pixels: 16k, the largest common still.
pub const IMAGE_SIDE_MAX: u32 = 16_384;
/// Most pixels of one picture: the film needs 96 bytes for each (6.4 GiB here).
pub const IMAGE_PIXELS_MAX: u64 = 1 << 26;
/// Most samples per pixel: two halves of 2^23 keep every index in 32 bits and
/// every sum of a run below 2^62 (see [`crate::film::SAMPLE_MAX`]).
pub const SAMPLES_MAX: u32 = 1 << 24;
/// Smallest and largest error that a job may stop at (relative mean squared error):
/// below, a million samples per pixel do not get there; above, nothing is seen.
pub const ERROR_TARGET_MIN: f64 = 1e-9;
/// See [`ERROR_TARGET_MIN`].
pub const ERROR_TARGET_MAX: f64 = 10.0;
/// Longest time that a job may be given, in seconds: a year.
pub const STOP_SECONDS_MAX: u32 = 366 * 86_400;
/// Most cuts of a job's samples beside its blocks: additions to a job that stood
/// at an odd number of samples. Further ones must start at a multiple of 128.
pub const CUTS_MAX: usize = 16;
/// Most frames of one job, and one past the largest number of a frame; rows are
/// made lazily, so this bounds numbers only.
pub const FRAMES_MAX: u32 = 1_000_000;
/// Most film hashes that a job's own JSON lists (9 KiB); jobs of more frames have
/// theirs in the paged list of frames.
pub const FILM_HASHES_MAX: u32 = 128;
/// Side of a tile in pixels: 64 x 64 keeps a part below 400 KiB and gives two
/// cores 128 tiles on the smallest common picture.
pub const TILE_SIDE: u32 = 64;
/// Largest scene.json: a scene of a hundred thousand instances fits.
pub const SCENE_BYTES_MAX: usize = 32 << 20;
/// Largest single asset: a mesh of ten million triangles as OBJ text.
pub const ASSET_BYTES_MAX: u64 = 2 << 30;
/// Most assets in one manifest.
pub const ASSETS_MAX: usize = 10_000;
/// Longest asset name in a manifest, in bytes.
pub const ASSET_NAME_BYTES_MAX: usize = 512;
/// Most triangles of one mesh: prim ids stay below 2^28, trees below 16 GiB.
pub const TRIANGLES_MAX: usize = 50_000_000;
/// Most vertices of one mesh, for the same reason.
pub const VERTICES_MAX: usize = 50_000_000;
/// Most instances of one scene.
pub const INSTANCES_MAX: usize = 1_000_000;
/// Most keys of one path: ten minutes at a key for every frame.
pub const KEYS_MAX: usize = 10_000;
/// Most instances between one and the world, itself counted: each is a transform
/// for every ray that meets it.
pub const INSTANCE_DEPTH_MAX: usize = 8;
/// Most materials of one scene.
pub const MATERIALS_MAX: usize = 10_000;
/// Most cloud particles and sprites of one scene, together.
pub const PARTICLES_MAX: usize = 5_000_000;
/// Most pixels of a picture that a cloud is formed by: 4096 x 4096, more than
/// there can be particles; the running sum over them takes 128 MiB.
pub const CLOUD_PIXELS_MAX: u64 = 1 << 24;
/// Most pixels of all such pictures of a scene: 768 MiB of running sums.
pub const CLOUD_PIXELS_ALL_MAX: u64 = 1 << 26;
/// Most texels of one texture: 16k x 8k.
pub const TEXELS_MAX: u64 = 1 << 27;
/// Memory an image decoder may take for one texture, in bytes.
pub const TEXTURE_DECODE_BYTES_MAX: u64 = 2 << 30;
/// Longest path in scattering events. A safety net, not a setting: from the 256th
/// scattering on one path in a thousand ends by roulette at each, so nobody comes
/// here (0.999^65000 is 6e-29), and hits of the cap are counted.
pub const PATH_DEPTH_MAX: u32 = 65_536;
/// Scatterings that may draw from Sobol points: one after the other gains less, and
/// 2 + 2 * 8 groups of dimensions are more than any path in a picture makes use of.
pub const SOBOL_SCATTERINGS_MAX: u32 = 8;
/// Scatterings before Russian roulette may begin: beyond a few dozen a path only
/// takes time.
pub const ROULETTE_FROM_MAX: u32 = 64;
/// The chance to survive roulette may be bounded from below by at least this, so
/// that no sample counts for more than a thousand, and by at most
/// [`SURVIVAL_MIN_MAX`], so that white clouds come to an end.
pub const SURVIVAL_MIN_MIN: f64 = 0.001;
/// Highest lower bound of the chance to survive.
pub const SURVIVAL_MIN_MAX: f64 = 0.99;
/// Memory of all textures of a scene, in bytes: a worker holds two scenes.
pub const TEXTURES_BYTES_MAX: u64 = 4 << 30;
/// Largest JSON body of any request but a job's submission.
pub const JSON_BODY_BYTES_MAX: usize = 1 << 20;
/// Largest JSON body of a job's submission (a manifest of [`ASSETS_MAX`]).
pub const SUBMIT_BODY_BYTES_MAX: usize = 16 << 20;
/// Most runs in one lease: bounds the answer and the claim transaction.
pub const LEASE_RUNS_MAX: usize = 64;
/// Most sample indices (of each half) in one run: 2^12 samples of at most 2^50
/// (see [`crate::film::SAMPLE_MAX`]) keep a run's sums below 2^62.
pub const RUN_SAMPLES_PER_HALF_MAX: u32 = 1 << 12;
/// Most units of one frame, since their rows are made in one transaction
/// (about a second): 4K at 65,536 samples per pixel is just below.
pub const FRAME_UNITS_MAX: u64 = 1 << 20;
/// Longest wait of a lease request, in milliseconds: below common proxy limits.
pub const LEASE_WAIT_MS_MAX: u64 = 20_000;
/// Lowest and highest priority of a job: room for a ladder of hundreds, tens and ones
/// as render queues commonly have it, and short enough to be compared at a glance.
pub const PRIORITY_MIN: i32 = -1000;
/// See [`PRIORITY_MIN`].
pub const PRIORITY_MAX: i32 = 1000;
/// Changes of a job that its log reaches back: each change has at most one event, so
/// that a job keeps at most so many (some 3 MB).
pub const LOG_CHANGES_MAX: i64 = 10_000;
/// Longest name of a job or worker, in bytes.
pub const NAME_BYTES_MAX: usize = 200;
/// Longest address of a webhook, in bytes: what browsers and proxies bear.
pub const WEBHOOK_URL_BYTES_MAX: usize = 2000;
/// Shortest and longest secret of a webhook, in bytes: 16 random ones cannot be
/// guessed.
pub const WEBHOOK_SECRET_BYTES_MIN: usize = 16;
/// See [`WEBHOOK_SECRET_BYTES_MIN`].
pub const WEBHOOK_SECRET_BYTES_MAX: usize = 200;
/// Bad samples that a part describes one by one; the rest is only counted.
pub const BAD_SAMPLES_LISTED_MAX: usize = 16;
/// Samples (per half) that carry features (albedo, normal, depth): these are
/// noise-free enough after a few, and cost traffic.
pub const FEATURE_SAMPLES: u32 = 16;
/// Share of samples that may be bad before the job fails.
pub const BAD_SAMPLE_SHARE_MAX: f64 = 1e-6;
/// Most passes of the bloom's box filter: three are within a few per cent of a
/// Gaussian.
pub const BLOOM_PASSES_MAX: u32 = 3;
/// Largest bloom strength. One already doubles the light above the threshold; the
/// rest is room for effects, short of overflow.
pub const BLOOM_STRENGTH_MAX: f32 = 100.0;
/// Most volumes of one scene: every ray asks each of them.
pub const VOLUMES_MAX: usize = 64;
/// Most voxels of all volumes of a scene: 512 MiB as f32.
pub const VOXELS_MAX: usize = 1 << 27;
/// Most voxels along one side of an ellipsoid of noise: 2^24 in all take some
/// seconds to compute.
pub const VOLUME_RESOLUTION_MAX: u32 = 256;
/// Thickest volume in mean free paths: tracking takes about one step for each. The
/// thickest cloud is some hundreds; nothing looks different beyond.
pub const OPTICAL_THICKNESS_MAX: f64 = 1e5;
/// Most steps of a march across one volume.
pub const MARCH_STEPS_MAX: u32 = 100_000;
