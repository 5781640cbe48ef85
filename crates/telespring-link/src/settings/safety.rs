//! `[safety]`: what keeps the person safe whatever the network does.

use serde::Deserialize;
use telespring::InvalidInput;
use telespring::session::Span;

use super::range::span;
use crate::site::Safety;

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
pub(super) struct Text {
    silence: Option<f64>,
    stall: Option<f64>,
    ramp_out: Option<f64>,
}

pub(super) fn read(text: &Text) -> Result<Safety, InvalidInput> {
    let usual = Safety::default();
    let time = |field: &str, given: Option<f64>, usual: Span| {
        given.map_or(Ok(usual), |given| span(field, given, [0.005, 10.0], usual.seconds()))
    };
    let safety = Safety {
        silence: time("safety.silence", text.silence, usual.silence)?,
        stall: time("safety.stall", text.stall, usual.stall)?,
        ramp_out: time("safety.ramp_out", text.ramp_out, usual.ramp_out)?,
    };
    safety.check()?;
    Ok(safety)
}
