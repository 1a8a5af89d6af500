//! Who may do what: tokens, roles, rates.
//!
//! A coordinator that only this machine reaches, and whose store never had a
//! token, lets everybody do everything. Any other demands a token with each
//! request. Tokens are rows of the store, so that all coordinators
//! know the same ones; the store holds their hashes alone.

mod cache;
mod caller;
mod guard;
mod local;
mod needs;
mod rates;
mod role;
mod token;

pub(crate) use cache::Tokens;
pub(crate) use caller::Caller;
pub(crate) use guard::guard;
pub(crate) use rates::Rates;
pub use role::{Role, UnknownRole};
pub use token::{NewToken, TokenError, adopt, create, generate};
