//! What database and object store take. The stores own these and count by themselves,
//! so that nobody who uses them has to.

use super::timer::{Seconds, Timer};
use prometheus_client::encoding::EncodeLabelSet;
use prometheus_client::metrics::counter::Counter;
use prometheus_client::metrics::family::Family;
use prometheus_client::metrics::histogram::Histogram;
use prometheus_client::registry::{Registry, Unit};

/// Which transaction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Transaction {
    /// Units are leased.
    Claim,
    /// A result is counted.
    Commit,
    /// A worker is heard of.
    Heartbeat,
    /// A lease ends undone.
    EndLease,
    /// A folded film takes its place.
    Fold,
    /// A try whether the database can be written.
    Probe,
}

impl Transaction {
    const ALL: [Self; 6] = [
        Self::Claim,
        Self::Commit,
        Self::Heartbeat,
        Self::EndLease,
        Self::Fold,
        Self::Probe,
    ];

    const fn name(self) -> &'static str {
        match self {
            Self::Claim => "claim",
            Self::Commit => "commit",
            Self::Heartbeat => "heartbeat",
            Self::EndLease => "end_lease",
            Self::Fold => "fold",
            Self::Probe => "probe",
        }
    }
}

/// How an audit ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Audited {
    /// Two workers said the same.
    Equal,
    /// Somebody was wrong.
    Unequal,
    /// Nobody could be asked, or nobody agreed.
    Skipped,
}

impl Audited {
    const ALL: [Self; 3] = [Self::Equal, Self::Unequal, Self::Skipped];

    const fn name(self) -> &'static str {
        match self {
            Self::Equal => "equal",
            Self::Unequal => "unequal",
            Self::Skipped => "skipped",
        }
    }
}

#[derive(Clone, Debug, PartialEq, Eq, Hash, EncodeLabelSet)]
struct TransactionLabel {
    transaction: &'static str,
}

#[derive(Clone, Debug, PartialEq, Eq, Hash, EncodeLabelSet)]
struct OutcomeLabel {
    outcome: &'static str,
}

#[derive(Clone, Debug, PartialEq, Eq, Hash, EncodeLabelSet)]
struct OperationLabel {
    operation: &'static str,
}

/// What a store of rows measures.
#[derive(Clone, Debug)]
pub(crate) struct StoreMeasures {
    transactions: Family<TransactionLabel, Histogram, Seconds>,
    audits: Family<OutcomeLabel, Counter>,
}

impl Default for StoreMeasures {
    fn default() -> Self {
        let transactions = Family::new_with_constructor(Seconds);
        let audits = Family::default();
        // Known from the first answer on: a rate needs a zero to begin with.
        for kind in Transaction::ALL {
            let transaction = kind.name();
            drop(transactions.get_or_create(&TransactionLabel { transaction }));
        }
        for audited in Audited::ALL {
            let outcome = audited.name();
            drop(audits.get_or_create(&OutcomeLabel { outcome }));
        }
        Self {
            transactions,
            audits,
        }
    }
}

impl StoreMeasures {
    /// A transaction begins, with its wait for a connection.
    pub(crate) fn transaction(&self, kind: Transaction) -> Timer {
        let transaction = kind.name();
        let label = TransactionLabel { transaction };
        Timer::of(self.transactions.get_or_create_owned(&label))
    }

    /// An audit ended.
    pub(crate) fn audited(&self, audited: Audited) {
        let outcome = audited.name();
        self.audits.get_or_create(&OutcomeLabel { outcome }).inc();
    }

    pub(super) fn register(&self, registry: &mut Registry) {
        registry.register_with_unit(
            "database_transaction",
            "Transactions, with their wait for a connection",
            Unit::Seconds,
            self.transactions.clone(),
        );
        registry.register(
            "audits",
            "Audited runs by how they ended; unequal is an alarm",
            self.audits.clone(),
        );
    }
}

/// What is done with an object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Operation {
    /// Written whole.
    Put,
    /// Read whole.
    Get,
    /// Opened, to be read in pieces.
    Open,
    /// Removed.
    Delete,
}

impl Operation {
    const ALL: [Self; 4] = [Self::Put, Self::Get, Self::Open, Self::Delete];

    const fn name(self) -> &'static str {
        match self {
            Self::Put => "put",
            Self::Get => "get",
            Self::Open => "open",
            Self::Delete => "delete",
        }
    }
}

/// What a store of objects measures.
#[derive(Clone, Debug)]
pub(crate) struct ObjectMeasures {
    operations: Family<OperationLabel, Histogram, Seconds>,
    errors: Counter,
}

impl Default for ObjectMeasures {
    fn default() -> Self {
        let operations = Family::new_with_constructor(Seconds);
        for kind in Operation::ALL {
            let operation = kind.name();
            drop(operations.get_or_create(&OperationLabel { operation }));
        }
        let errors = Counter::default();
        Self { operations, errors }
    }
}

impl ObjectMeasures {
    /// An operation begins.
    pub(crate) fn operation(&self, kind: Operation) -> Timer {
        let operation = kind.name();
        let label = OperationLabel { operation };
        Timer::of(self.operations.get_or_create_owned(&label))
    }

    /// One failed, by more than that there is no such object.
    pub(crate) fn failed(&self) {
        self.errors.inc();
    }

    pub(super) fn register(&self, registry: &mut Registry) {
        registry.register_with_unit(
            "object_operation",
            "Operations on the object store",
            Unit::Seconds,
            self.operations.clone(),
        );
        registry.register(
            "object_errors",
            "Operations on the object store that failed, its own repetitions included",
            self.errors.clone(),
        );
    }
}
