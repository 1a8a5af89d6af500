//! The loop over scenes, variants, seeds and numbers of samples.

use super::bias::{Difference, test_bias};
use super::point::{Point, Reference, averaged, measure};
use super::prepare::{Load, Prepared, prepare};
use super::progress::{Progress, Told};
use super::reference::{NoReference, given, rendered};
use super::store::{Store, slug};
use super::{Options, SceneStudy, Study, StudyError, VariantStudy, key};
use crate::develop::{exposure_of, shown_png};
use crate::heat::heat_png;
use crate::measure::{FrameSums, How, MeasureError, Spent, render_more};
use crate::variants::Variant;
use shearwater_shared::limits::TILE_SIDE;
use shearwater_tracer::BUILD;
use std::sync::atomic::AtomicBool;

/// Sample indices per half of one run, where a variant names none: that of the farm.
const BLOCK: u32 = 64;

/// What every part of a study needs.
struct Context<'a> {
    options: &'a Options,
    load: &'a Load<'a>,
    store: &'a Store,
    cancel: &'a AtomicBool,
}

/// Measure what `options` ask for, skipping what `store` has. `tell` hears how far it is.
/// A variant that cannot be rendered says so in its place and stops no other.
///
/// # Errors
/// [`StudyError`]: `cancel` was set, the store fails, a scene itself is wrong.
pub fn run_study(
    options: &Options,
    load: &Load<'_>,
    store: &Store,
    cancel: &AtomicBool,
    tell: &mut dyn FnMut(&Told<'_>),
) -> Result<Study, StudyError> {
    let context = Context {
        options,
        load,
        store,
        cancel,
    };
    let mut bases = Vec::new();
    for (number, scene) in options.scenes.iter().enumerate() {
        let base = prepare(
            load,
            number,
            &scene.bytes,
            &Variant::default(),
            options.size,
        );
        bases.push(base.map_err(StudyError::Scene)?);
    }
    let mut progress = Progress::new(total_samples(options, &bases), tell);
    let mut scenes = Vec::new();
    for (number, base) in bases.iter().enumerate() {
        scenes.push(study_scene(&context, number, base, &mut progress)?);
    }
    test_all(&mut scenes);
    Ok(Study {
        build: BUILD.to_owned(),
        baseline: options.baseline.clone(),
        seeds: options.seeds,
        scenes,
        rendered_samples: progress.rendered(),
    })
}

fn total_samples(options: &Options, bases: &[Prepared]) -> u64 {
    let most = options.counts.last().copied().unwrap_or(0);
    let own = options.variants.iter().filter(|v| v.own_reference).count();
    let references = if options.reference.is_some() {
        own
    } else {
        own + 1
    };
    let of_pixel = options.variants.len() as u64 * u64::from(options.seeds) * u64::from(most)
        + references as u64 * u64::from(options.reference_spp);
    let pixels = |base: &Prepared| u64::from(base.size.0) * u64::from(base.size.1);
    bases.iter().map(pixels).sum::<u64>() * of_pixel
}

fn study_scene(
    context: &Context<'_>,
    number: usize,
    base: &Prepared,
    progress: &mut Progress<'_>,
) -> Result<SceneStudy, StudyError> {
    let Context {
        options,
        store,
        cancel,
        ..
    } = *context;
    let reference = match given(options, base.size) {
        Some(given) => given.map_err(StudyError::Scene)?,
        None => rendered(base, options, store, cancel, progress).map_err(|e| match e {
            NoReference::Study(e) => e,
            NoReference::Variant(text) => StudyError::Scene(text),
        })?,
    };
    let exposure = exposure_of(&reference.rgb);
    let mut variants = Vec::new();
    for variant in &options.variants {
        variants.push(study_variant(
            context, number, variant, &reference, exposure, progress,
        )?);
    }
    let (width, height) = base.size;
    Ok(SceneStudy {
        name: base.name.clone(),
        file: options.scenes[number].file.clone(),
        width,
        height,
        reference_png: shown_png(width as usize, &reference.rgb, exposure).unwrap_or_default(),
        reference: Some(reference.about),
        variants,
    })
}

fn study_variant(
    context: &Context<'_>,
    number: usize,
    variant: &Variant,
    reference: &Reference,
    exposure: f32,
    progress: &mut Progress<'_>,
) -> Result<VariantStudy, StudyError> {
    let Context {
        options,
        store,
        cancel,
        ..
    } = *context;
    let mut study = VariantStudy {
        variant: variant.clone(),
        threads: variant.threads.unwrap_or(options.threads),
        points: Vec::new(),
        bias: None,
        own_reference: None,
        reference_scatter: (0.0, 0.0),
        pictures: None,
        failure: None,
    };
    let scene = &options.scenes[number];
    let prepared = match prepare(context.load, number, &scene.bytes, variant, options.size) {
        Ok(prepared) => prepared,
        Err(text) => {
            progress.say(&format!("{}: {text}", variant.name));
            study.failure = Some(text);
            return Ok(study);
        }
    };
    let mut own = None;
    if variant.own_reference {
        match rendered(&prepared, options, store, cancel, progress) {
            Ok(found) => own = Some(found),
            Err(NoReference::Study(error)) => return Err(error),
            Err(NoReference::Variant(text)) => {
                study.failure = Some(text);
                return Ok(study);
            }
        }
    }
    let reference = own.as_ref().unwrap_or(reference);
    study.own_reference = own.as_ref().map(|own| own.about.clone());
    study.reference_scatter = (reference.held.variance, reference.held.fourth);
    match measure_seeds(
        context, &prepared, &mut study, reference, exposure, progress,
    ) {
        Ok(()) => Ok(study),
        Err(NoReference::Study(error)) => Err(error),
        Err(NoReference::Variant(text)) => {
            study.failure = Some(text);
            Ok(study)
        }
    }
}

fn measure_seeds(
    context: &Context<'_>,
    prepared: &Prepared,
    study: &mut VariantStudy,
    reference: &Reference,
    exposure: f32,
    progress: &mut Progress<'_>,
) -> Result<(), NoReference> {
    let counts = &context.options.counts;
    let mut of_seeds = vec![Vec::new(); counts.len()];
    for seed in 0..context.options.seeds {
        let mut run = Run::new(prepared, study, reference, seed.into());
        let points = run.points(context, exposure, progress)?;
        for (of_count, point) in of_seeds.iter_mut().zip(points) {
            of_count.push(point);
        }
        if seed == 0 {
            let read = |name: String| context.store.read(&name);
            study.pictures = read(run.file("png")).zip(read(run.file("flip.png")));
        }
    }
    study.points = of_seeds
        .iter()
        .filter_map(|points| averaged(points))
        .collect();
    Ok(())
}

/// One variant with one seed.
struct Run<'a> {
    prepared: &'a Prepared,
    reference: &'a Reference,
    name: String,
    how: How,
    seed: u64,
    /// Beginning of the names of its files.
    stem: String,
}

impl<'a> Run<'a> {
    fn new(
        prepared: &'a Prepared,
        study: &VariantStudy,
        reference: &'a Reference,
        seed: u64,
    ) -> Self {
        let variant = &study.variant;
        let how = How {
            threads: study.threads,
            tile: variant.tile.unwrap_or(TILE_SIDE),
            block: variant.block.unwrap_or(BLOCK),
        };
        let key = key::of_run(&prepared.key, seed, how, &reference.key);
        let (scene, own) = (slug(&prepared.name), slug(&variant.name));
        Self {
            prepared,
            reference,
            name: format!("{} / {}", prepared.name, variant.name),
            how,
            seed,
            stem: format!("{scene}-{own}-{seed}-{key}"),
        }
    }

    fn file(&self, ending: &str) -> String {
        format!("{}.{ending}", self.stem)
    }

    /// All points: what the store has, then the rest, each from where the last ended.
    fn points(
        &mut self,
        context: &Context<'_>,
        exposure: f32,
        progress: &mut Progress<'_>,
    ) -> Result<Vec<Point>, NoReference> {
        let Context {
            options,
            store,
            cancel,
            ..
        } = *context;
        let (width, height) = self.prepared.size;
        let samples = |spp: u32| u64::from(spp) * u64::from(width) * u64::from(height);
        let point_file = |spp: u32| self.file(&format!("{spp}.json"));
        let mut points: Vec<Point> = options
            .counts
            .iter()
            .map_while(|&spp| store.read_json(&point_file(spp)))
            .collect();
        if points.len() == options.counts.len() {
            progress.skip(samples(options.counts.last().copied().unwrap_or(0)));
            return Ok(points);
        }
        let zero = || FrameSums::zero(width, height);
        let done = points.last().map_or(0, |point| point.spp);
        let stored = store.read_sums(&self.file("sums"), self.prepared.size);
        let mut sums = stored
            .filter(|sums| 2 * sums.samples_per_half == done)
            .unwrap_or_else(|| {
                // Without its sums a count cannot be gone on from.
                points.clear();
                zero()
            });
        progress.skip(samples(2 * sums.samples_per_half));
        let most = options.counts.last().copied().unwrap_or(2);
        let frame = self.prepared.frame(most, self.seed);
        let frame = frame.map_err(NoReference::Variant)?;
        for &spp in &options.counts[points.len()..] {
            let before = 2 * sums.samples_per_half;
            let text = format!("{}: {spp} spp", self.name);
            let mut alive = |running| progress.alive(&text, running);
            let more = render_more(&frame, &mut sums, spp / 2, self.how, cancel, &mut alive)
                .map_err(|e| match e {
                    MeasureError::Cancelled => NoReference::Study(StudyError::Cancelled),
                    MeasureError::Thread(_) => NoReference::Variant(e.to_string()),
                })?;
            progress.finish(samples(spp - before));
            let last = points.last();
            let spent = Spent {
                core_s: more.core_s + last.map_or(0.0, |point| point.core_s),
                wall_s: more.wall_s + last.map_or(0.0, |point| point.wall_s),
            };
            let (point, flip) = measure(&sums, spent, self.reference);
            self.keep(store, &sums, &point, flip.as_deref(), exposure)
                .map_err(NoReference::Study)?;
            progress.say(&format!(
                "{text}: {:.2} core s, relMSE {:.3e}",
                point.core_s, point.rel_mse
            ));
            // JSON may change the last bit: take what the next run will read.
            let kept = store.read_json(&self.file(&format!("{spp}.json")));
            points.push(kept.unwrap_or(point));
        }
        Ok(points)
    }

    /// The sums first: a point whose sums are missing is measured again.
    fn keep(
        &self,
        store: &Store,
        sums: &FrameSums,
        point: &Point,
        flip: Option<&[f32]>,
        exposure: f32,
    ) -> Result<(), StudyError> {
        let width = sums.width as usize;
        store.write(&self.file("sums"), &sums.encode())?;
        if self.seed == 0 {
            let png = shown_png(width, &sums.mean(), exposure).unwrap_or_default();
            store.write(&self.file("png"), &png)?;
            let map = flip.and_then(|flip| heat_png(width, flip).ok());
            store.write(&self.file("flip.png"), &map.unwrap_or_default())?;
        }
        store.write_json(&self.file(&format!("{}.json", point.spp)), point)?;
        Ok(())
    }
}

/// One test for each variant that was rendered, all at one rate of false alarms.
fn test_all(scenes: &mut [SceneStudy]) {
    let measured = |v: &&VariantStudy| !v.points.is_empty();
    let tests = scenes
        .iter()
        .flat_map(|s| &s.variants)
        .filter(measured)
        .count();
    for variant in scenes.iter_mut().flat_map(|s| &mut s.variants) {
        let (variance, fourth) = variant.reference_scatter;
        variant.bias = variant.points.last().map(|point| {
            let with_reference = Difference {
                variance: point.weighted.variance + variance,
                fourth: point.weighted.fourth + fourth,
                ..point.weighted
            };
            test_bias(&with_reference, tests)
        });
    }
}
