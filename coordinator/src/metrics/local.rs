//! What this process sees at the moment: its queues, its troubles, its disk.

use crate::app::App;
use prometheus_client::encoding::EncodeLabelSet;
use prometheus_client::metrics::family::Family;
use prometheus_client::metrics::gauge::Gauge;
use prometheus_client::registry::{Registry, Unit};

#[derive(Clone, Debug, PartialEq, Eq, Hash, EncodeLabelSet)]
struct Queue {
    queue: &'static str,
}

#[derive(Clone, Debug, PartialEq, Eq, Hash, EncodeLabelSet)]
struct Store {
    store: &'static str,
}

/// As it is now.
pub(super) fn register(registry: &mut Registry, app: &App) {
    let (used, most) = (Family::<Queue, Gauge>::default(), Family::default());
    for place in app.places() {
        let queue = Queue { queue: place.name };
        set(&used, &queue, place.used);
        set(&most, &queue, place.most);
    }
    registry.register("places_used", "Places of each queue that are taken", used);
    registry.register(
        "places",
        "Places of each queue; who finds none waits or is sent away",
        most,
    );
    let trouble = Family::<Store, Gauge>::default();
    for (store, broken) in [
        ("database", app.troubles.database_is_away()),
        ("objects", app.troubles.objects_are_away()),
    ] {
        set(&trouble, &Store { store }, usize::from(broken));
    }
    registry.register(
        "store_trouble",
        "1 while a store cannot be written, so that work pauses",
        trouble,
    );
    let free = Family::<Store, Gauge>::default();
    for (store, folder) in app.folders() {
        if let Ok(stat) = rustix::fs::statvfs(folder) {
            let bytes = stat.f_bavail.saturating_mul(stat.f_frsize);
            let bytes = usize::try_from(bytes).unwrap_or(usize::MAX);
            set(&free, &Store { store }, bytes);
        }
    }
    registry.register_with_unit(
        "disk_free",
        "Free space where a store is a folder of this machine",
        Unit::Bytes,
        free,
    );
}

fn set<L: Clone + std::hash::Hash + Eq>(family: &Family<L, Gauge>, label: &L, value: usize) {
    let value = i64::try_from(value).unwrap_or(i64::MAX);
    family.get_or_create(label).set(value);
}
