//! Rows of the table of hard cases: what was expected, what was measured, how
//! far apart the two may lie.
//!
//! Knows nothing of the renderer, so that another crate's tests can take this
//! file and `document.rs` by `#[path]` and write their own part of the document.
#![allow(dead_code, reason = "each test binary uses its own part")]

use std::sync::OnceLock;

/// How much work a statistical case puts in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Form {
    /// For every test run: seconds.
    Fast,
    /// For the document: minutes.
    Full,
}

impl Form {
    /// [`Form::Full`] if the environment says `HARD_CASES=full`.
    pub(crate) fn of_environment() -> Self {
        if std::env::var("HARD_CASES").is_ok_and(|form| form == "full") {
            Self::Full
        } else {
            Self::Fast
        }
    }

    /// `fast` or `full`, whichever this is.
    pub(crate) fn pick<T>(self, fast: T, full: T) -> T {
        match self {
            Self::Fast => fast,
            Self::Full => full,
        }
    }
}

/// Where a measured value must lie.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Bound {
    /// At most this far from the expected value; 0 means equal.
    Within(f64),
    /// Not above the expected value.
    AtMost,
    /// Not below the expected value.
    AtLeast,
}

/// Where a tolerance comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Law {
    /// Nothing is random: quadrature, rounding, or exact.
    Fixed,
    /// So many standard errors of the mean, measured from the samples themselves.
    Sigma(f64),
    /// A p-value against the level of one test of its family (Sidak 1967).
    Sidak,
}

/// One line of the table.
#[derive(Clone, Debug)]
pub(crate) struct Row {
    /// The parameters that tell it from its neighbours; empty for a case of one row.
    pub(crate) at: String,
    /// The exact or model's value, or the limit of a one-sided bound.
    pub(crate) expected: f64,
    /// What the renderer's code gave.
    pub(crate) measured: f64,
    /// Where it must lie.
    pub(crate) bound: Bound,
    /// Where the tolerance comes from.
    pub(crate) law: Law,
}

impl Row {
    /// `measured` within `tolerance` of `expected`, nothing random.
    pub(crate) fn near(
        at: impl Into<String>,
        expected: f64,
        measured: f64,
        tolerance: f64,
    ) -> Self {
        let (bound, law) = (Bound::Within(tolerance), Law::Fixed);
        Self {
            at: at.into(),
            expected,
            measured,
            bound,
            law,
        }
    }

    /// Equal numbers (counts, bits).
    pub(crate) fn exact(at: impl Into<String>, expected: f64, measured: f64) -> Self {
        Self::near(at, expected, measured, 0.0)
    }

    /// `measured` within `sigmas` of its own standard errors, and `rounding` more
    /// for what is known of the expected value or lost to 32-bit floats.
    pub(crate) fn sampled(
        at: impl Into<String>,
        expected: f64,
        measured: f64,
        sigmas: f64,
        standard_error: f64,
        rounding: f64,
    ) -> Self {
        let bound = Bound::Within(sigmas * standard_error + rounding);
        Self {
            at: at.into(),
            expected,
            measured,
            bound,
            law: Law::Sigma(sigmas),
        }
    }

    /// `measured` not above `limit`.
    pub(crate) fn at_most(at: impl Into<String>, limit: f64, measured: f64) -> Self {
        let (bound, law) = (Bound::AtMost, Law::Fixed);
        Self {
            at: at.into(),
            expected: limit,
            measured,
            bound,
            law,
        }
    }

    /// `measured` not below `limit`.
    pub(crate) fn at_least(at: impl Into<String>, limit: f64, measured: f64) -> Self {
        let (bound, law) = (Bound::AtLeast, Law::Fixed);
        Self {
            at: at.into(),
            expected: limit,
            measured,
            bound,
            law,
        }
    }

    /// The smallest p-value of a family of tests whose single level is `level`.
    pub(crate) fn p_value(at: impl Into<String>, level: f64, measured: f64) -> Self {
        Self {
            law: Law::Sidak,
            ..Self::at_least(at, level, measured)
        }
    }

    /// The same under another law: for one-sided bounds that hold several sigma.
    pub(crate) fn by(self, law: Law) -> Self {
        Self { law, ..self }
    }

    /// Whether the measured value lies where it must. NaN lies nowhere.
    pub(crate) fn holds(&self) -> bool {
        match self.bound {
            Bound::Within(tolerance) => (self.measured - self.expected).abs() <= tolerance,
            Bound::AtMost => self.measured <= self.expected,
            Bound::AtLeast => self.measured >= self.expected,
        }
    }

    /// How many times larger the deviation could be, as text: tolerance over
    /// deviation, or the quotient of limit and value. Below 1 the row fails.
    pub(crate) fn margin(&self) -> String {
        let margin = match self.bound {
            Bound::Within(_) if self.measured == self.expected => return "equal".to_owned(),
            Bound::Within(tolerance) => tolerance / (self.measured - self.expected).abs(),
            Bound::AtMost => self.expected / self.measured,
            Bound::AtLeast => self.measured / self.expected,
        };
        if margin >= 99.5 {
            "> 99".to_owned()
        } else if margin < 10.0 {
            format!("{margin:.2}")
        } else {
            format!("{margin:.0}")
        }
    }
}

/// One hard case: rows that one piece of code makes.
pub(crate) struct Case {
    /// What it is, for the table.
    pub(crate) name: &'static str,
    /// Where the expected values come from, and where the model departs from the
    /// ideal; empty if the name says it all.
    pub(crate) note: &'static str,
    /// The change to the renderer that was tried, and made it fail.
    pub(crate) broken_by: &'static str,
    /// Measures.
    pub(crate) rows: fn(Form) -> Vec<Row>,
}

/// Cases of one subject; a static of each file.
pub(crate) struct Section {
    /// Its heading.
    pub(crate) title: &'static str,
    /// In order.
    pub(crate) cases: &'static [Case],
    measured: OnceLock<Vec<Vec<Row>>>,
}

impl Section {
    /// A section that has not been measured yet.
    pub(crate) const fn new(title: &'static str, cases: &'static [Case]) -> Self {
        Self {
            title,
            cases,
            measured: OnceLock::new(),
        }
    }

    /// Rows of each case, measured once for all tests of the binary.
    pub(crate) fn measured(&self) -> &[Vec<Row>] {
        self.measured.get_or_init(|| {
            let form = Form::of_environment();
            let timed = |case: &Case| {
                let began = std::time::Instant::now();
                let rows = (case.rows)(form);
                println!("{:6.2} s  {}", began.elapsed().as_secs_f64(), case.name);
                rows
            };
            self.cases.iter().map(timed).collect()
        })
    }

    /// Prints the section and fails if a row does not hold, or if the document
    /// does not have it.
    pub(crate) fn check(&self) {
        let failed = self
            .measured()
            .iter()
            .flatten()
            .filter(|row| !row.holds())
            .count();
        println!("{}", super::document::section(self));
        super::document::keep(self);
        assert_eq!(
            failed, 0,
            "{}: {failed} rows do not hold (marked FAILS above)",
            self.title
        );
    }
}

/// A number with about `digits` significant digits, as short as it goes.
pub(crate) fn number(value: f64, digits: usize) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    if !value.is_finite() {
        return format!("{value}");
    }
    let magnitude = libm::floor(libm::log10(value.abs())) as i32;
    if value.abs() < 1e15 && value == libm::trunc(value) {
        return format!("{value:.0}");
    }
    if !(-4..7).contains(&magnitude) {
        return format!("{value:.*e}", digits.saturating_sub(1));
    }
    let decimals = (digits as i32 - 1 - magnitude).max(0) as usize;
    format!("{value:.decimals$}")
}
