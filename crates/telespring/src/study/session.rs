//! The section `[session]`: what both sides do with the partner's motion.

use toml::{Table, Value};

use super::Study;
use super::entry::Entry;
use super::reader::Reader;
use crate::error::{InvalidInput, Result};
use crate::quantity::{self, Quantity};
use crate::session::architecture::{
    Architecture, GuardDesign, KalmanDesign, PlayoutDesign, PredictorDesign, SetPositionDesign,
    StrategyDesign, TimeDomainPassivityDesign, TwoLayerDesign, WaveDesign,
};
use crate::session::predictor::{MotionModel, Noise};
use crate::session::{AdaptiveDelay, Span};

impl Study {
    /// What both sides do with the partner's motion: in the study's rehearsal, and live.
    ///
    /// # Examples
    ///
    /// ```
    /// use telespring::study::Study;
    /// assert_eq!(Study::paper().session().label(), "spring");
    /// ```
    pub fn session(&self) -> &Architecture {
        &self.session
    }
}

/// Reads what both sides of the study's session do.
pub(super) fn read_session(reader: &Reader<'_>) -> Result<Architecture> {
    architecture_of(["strategy", "predictor", "playout"].map(|key| reader.get("session", key)))
}

/// The architecture of a study from its three entries.
pub(super) fn architecture_of(
    [strategy, predictor, playout]: [Option<Entry<'_, '_>>; 3],
) -> Result<Architecture> {
    Ok(Architecture {
        strategy: strategy.map_or(Ok(StrategyDesign::default()), |entry| read_strategy(&entry))?,
        predictor: predictor.map_or(Ok(PredictorDesign::default()), |entry| read_predictor(&entry))?,
        playout: playout.map_or(Ok(PlayoutDesign::default()), |entry| read_playout(&entry))?,
    })
}

/// A number of the session, or its usual value; without the sign of −0, which has no meaning and would not be written.
fn number(entry: Option<Entry<'_, '_>>, quantity: Quantity, usual: f64) -> Result<f64> {
    entry.map_or(Ok(usual), |entry| Ok(entry.number(quantity, "a number")? + 0.0))
}

/// The damping of a strategy that must take energy from the handle, N·s/m or, per energy, N·s/m per J.
fn loss(entry: Option<Entry<'_, '_>>, quantity: Quantity, usual: f64, why: &str) -> Result<f64> {
    let Some(entry) = entry else { return Ok(usual) };
    let value = entry.number(quantity, "a number")? + 0.0;
    if value > 0.0 {
        return Ok(value);
    }
    Err(entry.reject(
        format!("the damper must be stronger than 0: {why}"),
        format!("{usual:?} is the usual value; or choose another strategy."),
    ))
}

/// Reads the strategy of a session: a word, or a table with the kind and its settings.
pub(super) fn read_strategy(entry: &Entry<'_, '_>) -> Result<StrategyDesign> {
    let kind = entry.kind(&StrategyDesign::KINDS)?;
    let usual = StrategyDesign::of_kind(kind).unwrap_or_default();
    Ok(match usual {
        StrategyDesign::Spring | StrategyDesign::InjectedDamping => {
            entry.parts(["kind"])?;
            usual
        }
        StrategyDesign::Guard(usual) => {
            let parts = entry.parts(["kind", "share", "capacity", "intake"])?;
            let [_, share, capacity, intake] = parts.unwrap_or_default();
            StrategyDesign::Guard(GuardDesign {
                share: read_share(share, usual.share)?,
                capacity: number(capacity, quantity::ENERGY, usual.capacity)?,
                intake: number(intake, quantity::POWER, usual.intake)?,
            })
        }
        StrategyDesign::WaveVariables(usual) => {
            let [_, impedance, filter] = entry.parts(["kind", "impedance", "filter"])?.unwrap_or_default();
            StrategyDesign::WaveVariables(WaveDesign {
                impedance: number(impedance, quantity::IMPEDANCE, usual.impedance)?,
                filter: number(filter, quantity::SPAN, usual.filter)?,
            })
        }
        StrategyDesign::TimeDomainPassivity(usual) => {
            let [_, largest] = entry.parts(["kind", "largest_damping"])?.unwrap_or_default();
            let why = "it alone repays what came out too much";
            let largest_damping = loss(largest, quantity::DAMPING, usual.largest_damping, why)?;
            StrategyDesign::TimeDomainPassivity(TimeDomainPassivityDesign { largest_damping })
        }
        StrategyDesign::TwoLayer(usual) => {
            let keys = ["kind", "level", "transfer_rate", "filling", "largest_damping", "saturation"];
            let [_, level, transfer_rate, filling, largest_damping, saturation] =
                entry.parts(keys)?.unwrap_or_default();
            let why = "it alone fills a tank that has run empty on both sides";
            StrategyDesign::TwoLayer(TwoLayerDesign {
                level: number(level, quantity::ENERGY, usual.level)?,
                transfer_rate: number(transfer_rate, quantity::DECAY_RATE, usual.transfer_rate)?,
                filling: loss(filling, quantity::FILLING, usual.filling, why)?,
                largest_damping: loss(largest_damping, quantity::DAMPING, usual.largest_damping, why)?,
                saturation: number(saturation, quantity::RATIO, usual.saturation)?,
            })
        }
        StrategyDesign::SetPositionModulation(usual) => {
            let [_, damping, ceiling] = entry.parts(["kind", "damping", "ceiling"])?.unwrap_or_default();
            let why = "it pays for the hold of the spring and fills the reservoir";
            StrategyDesign::SetPositionModulation(SetPositionDesign {
                damping: loss(damping, quantity::DAMPING, usual.damping, why)?,
                ceiling: number(ceiling, quantity::ENERGY, usual.ceiling)?,
            })
        }
    })
}

/// Reads the share of a robot's loss that a session's guard may spend.
fn read_share(entry: Option<Entry<'_, '_>>, usual: f64) -> Result<f64> {
    let Some(entry) = entry else { return Ok(usual) };
    let share = entry.number(quantity::SHARE, "a number")? + 0.0;
    if share < 1.0 {
        return Ok(share);
    }
    Err(entry.reject(
        "the share of the loss that may be spent must be below 1",
        "With a share of 1 a motion never dies out: 0.7 leaves three tenths of the loss.",
    ))
}

/// Reads the predictor of a session: a word, or a table with the kind and its settings.
pub(super) fn read_predictor(entry: &Entry<'_, '_>) -> Result<PredictorDesign> {
    let kind = entry.kind(&PredictorDesign::KINDS)?;
    let usual = PredictorDesign::of_kind(kind).unwrap_or_default();
    let PredictorDesign::Kalman(usual_filter) = usual else {
        entry.parts(["kind"])?;
        return Ok(usual);
    };
    let [_, model, process, position] =
        entry.parts(["kind", "model", "process", "position"])?.unwrap_or_default();
    let model = match model {
        None => usual_filter.model,
        Some(model) => MotionModel::of_word(model.choice(&MotionModel::WORDS)?).unwrap_or(usual_filter.model),
    };
    if model != usual_filter.model && process.is_none() {
        let field = format!("{}.process", entry.field);
        let remedy = "Add process = 1.0, or the value that fits your recordings: the usual one is of a constant acceleration.";
        return Err(entry.place(InvalidInput::missing(field, "m²/s³", remedy)));
    }
    let noise = Noise {
        process: number(process, quantity::PROCESS_NOISE, usual_filter.noise.process)?,
        position: number(position, quantity::POSITION_NOISE, usual_filter.noise.position)?,
    };
    Ok(PredictorDesign::Kalman(KalmanDesign { model, noise }))
}

/// Reads the play-out of a session: a word, or a table with the kind and its settings.
pub(super) fn read_playout(entry: &Entry<'_, '_>) -> Result<PlayoutDesign> {
    let kind = entry.kind(&PlayoutDesign::KINDS)?;
    let PlayoutDesign::Adaptive(usual) = PlayoutDesign::of_kind(kind).unwrap_or_default() else {
        let [_, delay] = entry.parts(["kind", "delay"])?.unwrap_or_default();
        let delay = delay.map(|delay| number(Some(delay), quantity::DELAY, 0.0)).transpose()?;
        return Ok(PlayoutDesign::Fixed { delay });
    };
    let keys = ["kind", "quantile", "margin", "smallest", "largest", "window", "slew"];
    let [_, quantile, margin, smallest, largest, window, slew] = entry.parts(keys)?.unwrap_or_default();
    let span = |entry: Option<Entry<'_, '_>>, quantity: Quantity, usual: Span| {
        Ok(entry
            .map(|entry| entry.number(quantity, "a number"))
            .transpose()?
            .map_or(usual, Span::from_seconds))
    };
    let adaptive = AdaptiveDelay {
        quantile: number(quantile, quantity::SHARE, usual.quantile)?,
        margin: span(margin, quantity::SPAN, usual.margin)?,
        smallest: span(smallest, quantity::DELAY, usual.smallest)?,
        largest: span(largest, quantity::DELAY, usual.largest)?,
        window: span(window, quantity::SPAN_OF_TRIAL, usual.window)?,
        slew: number(slew, quantity::SHARE, usual.slew)?,
    };
    adaptive.check().map_err(|refusal| entry.place(refusal.within(&entry.field)))?;
    Ok(PlayoutDesign::Adaptive(adaptive))
}

/// A span of a session in seconds, as people write it.
fn seconds(span: Span) -> Value {
    Value::Float(span.0 as f64 / 1e9)
}

/// A part of an architecture as a study writes it: its kind, or a table where it has a setting that is not the usual one.
fn part(kind: &str, is_usual: bool, settings: &[(&str, Value)]) -> Value {
    if is_usual {
        return Value::String(kind.to_owned());
    }
    let kind = ("kind", Value::String(kind.to_owned()));
    let keys = std::iter::once(&kind).chain(settings);
    Value::Table(keys.map(|(key, value)| ((*key).to_owned(), value.clone())).collect())
}

impl StrategyDesign {
    /// The strategy as the value of the study's key.
    fn to_value(self) -> Value {
        let settings = match self {
            Self::Spring | Self::InjectedDamping => Vec::new(),
            Self::Guard(GuardDesign { share, capacity, intake }) => {
                vec![("share", share), ("capacity", capacity), ("intake", intake)]
            }
            Self::WaveVariables(WaveDesign { impedance, filter }) => {
                vec![("impedance", impedance), ("filter", filter)]
            }
            Self::TimeDomainPassivity(TimeDomainPassivityDesign { largest_damping }) => {
                vec![("largest_damping", largest_damping)]
            }
            Self::TwoLayer(TwoLayerDesign { level, transfer_rate, filling, largest_damping, saturation }) => {
                vec![
                    ("level", level),
                    ("transfer_rate", transfer_rate),
                    ("filling", filling),
                    ("largest_damping", largest_damping),
                    ("saturation", saturation),
                ]
            }
            Self::SetPositionModulation(SetPositionDesign { damping, ceiling }) => {
                vec![("damping", damping), ("ceiling", ceiling)]
            }
        };
        let settings: Vec<_> = settings.into_iter().map(|(key, value)| (key, Value::Float(value))).collect();
        part(self.kind(), Self::of_kind(self.kind()) == Some(self), &settings)
    }
}

impl PredictorDesign {
    /// The predictor as the value of the study's key.
    fn to_value(self) -> Value {
        let settings = match self {
            Self::Kalman(KalmanDesign { model, noise }) => {
                vec![
                    ("model", Value::String(model.word().to_owned())),
                    ("process", Value::Float(noise.process)),
                    ("position", Value::Float(noise.position)),
                ]
            }
            _ => Vec::new(),
        };
        part(self.kind(), Self::of_kind(self.kind()) == Some(self), &settings)
    }
}

impl PlayoutDesign {
    /// The play-out as the value of the study's key.
    fn to_value(self) -> Value {
        let settings = match self {
            Self::Fixed { delay } => delay.map(|delay| ("delay", Value::Float(delay))).into_iter().collect(),
            Self::Adaptive(AdaptiveDelay { quantile, margin, smallest, largest, window, slew }) => {
                vec![
                    ("quantile", Value::Float(quantile)),
                    ("margin", seconds(margin)),
                    ("smallest", seconds(smallest)),
                    ("largest", seconds(largest)),
                    ("window", seconds(window)),
                    ("slew", Value::Float(slew)),
                ]
            }
        };
        part(self.kind(), Self::of_kind(self.kind()) == Some(self), &settings)
    }
}

impl Architecture {
    /// The keys of the section `[session]` with their values, defaults filled in; a part with the usual settings is a word.
    ///
    /// # Examples
    ///
    /// ```
    /// use telespring::session::Architecture;
    /// let table = "strategy = {kind = \"guard\", share = 0.5}".parse().unwrap();
    /// let guarded = Architecture::from_table(&table)?;
    /// assert_eq!(guarded.to_table()["predictor"].as_str(), Some("hold"));
    /// assert_eq!(Architecture::from_table(&guarded.to_table())?, guarded);
    /// # Ok::<(), telespring::InvalidInput>(())
    /// ```
    pub fn to_table(&self) -> Table {
        let parts = [
            ("strategy", self.strategy.to_value()),
            ("predictor", self.predictor.to_value()),
            ("playout", self.playout.to_value()),
        ];
        parts.into_iter().map(|(key, value)| (key.to_owned(), value)).collect()
    }
}
