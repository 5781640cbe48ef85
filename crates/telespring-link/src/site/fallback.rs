//! What a site does under a bad network: soften, then pause, and say so.
//!
//! The force is multiplied by a share, which moves smoothly. The guard promises as much for a part of its force as for all of
//! it: its proof asks for a force of at most √(2 k S), and its account is told the force that acted.

use telespring::InvalidInput;
use telespring::session::playout::PlayoutReport;
use telespring::session::{LocalTime, Span};

/// From one look at the counts to the next.
const LOOK: Span = Span(100_000_000);
/// Looks in a window.
const WINDOW: usize = 10;
/// The share of the force moves by so much per second.
const SLOPE: f64 = 0.5;
/// A network is good again below this share of what makes it bad.
const GOOD: f64 = 0.5;

/// When a network is bad, and what happens then.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fallback {
    /// The largest share of packets lost within a second; 1 to pass over losses.
    pub loss: f64,
    /// The largest share of ticks within a second at which an old motion was held; 1 to pass over it.
    pub held: f64,
    /// The largest age of the partner's motion in use, s.
    pub age: f64,
    /// The share of the force while the network is bad; 1 to soften nothing.
    pub softened: f64,
    /// A network that is bad for this long leads to a pause.
    pub patience: Span,
    /// A network counts as good again once it has been good for this long.
    pub recovery: Span,
    /// So does a partner that is silent for this long.
    pub silence: Span,
}

impl Default for Fallback {
    /// Beyond 20 % lost, 30 % held or 0.5 s of age: half of the force, and a pause after 3 s; good again after 2 s. A pause
    /// after 2 s of silence.
    fn default() -> Self {
        Self {
            loss: 0.2,
            held: 0.3,
            age: 0.5,
            softened: 0.5,
            patience: Span(3_000_000_000),
            recovery: Span(2_000_000_000),
            silence: Span(2_000_000_000),
        }
    }
}

impl Fallback {
    /// Checks the values.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] with the field.
    pub fn check(&self) -> Result<(), InvalidInput> {
        let Self { loss, held, age, softened, patience, recovery, silence } = *self;
        for (field, share, usual) in
            [("loss", loss, "0.2"), ("held", held, "0.3"), ("softened", softened, "0.5")]
        {
            if !(0.0..=1.0).contains(&share) {
                let (field, remedy) = (format!("fallback.{field}"), format!("Give {usual}."));
                return Err(InvalidInput::new(field, share, "a share from 0 to 1", remedy));
            }
        }
        if !(age > 0.0 && age <= 60.0) {
            let remedy = "Give the age beyond which the coupling is of no use, for instance 0.5.";
            return Err(InvalidInput::new("fallback.age", age, "above 0, up to 60 s", remedy));
        }
        for (field, span, usual) in
            [("patience", patience, "3"), ("recovery", recovery, "2"), ("silence", silence, "2")]
        {
            if !(Span(100_000_000)..=Span(600_000_000_000)).contains(&span) {
                let (field, value) = (format!("fallback.{field}"), format!("{} s", span.seconds()));
                return Err(InvalidInput::new(field, value, "0.1 to 600 s", format!("Give {usual}.")));
            }
        }
        Ok(())
    }
}

/// What makes a network bad.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Badness {
    /// Too many packets are lost.
    Loss,
    /// An old motion is held too often.
    Held,
    /// The partner's motion is too old.
    Age,
    /// The partner is silent.
    Silence,
}

impl Badness {
    /// The cause in a word.
    pub fn word(self) -> &'static str {
        match self {
            Self::Loss => "loss",
            Self::Held => "held",
            Self::Age => "age",
            Self::Silence => "silence",
        }
    }
}

/// What a tick tells of the network.
#[derive(Debug, Clone, Copy)]
pub(super) struct Seen {
    /// When the partner's latest packet came, or the coupling began.
    pub(super) heard: LocalTime,
    /// The age in use, s.
    pub(super) age: Option<f64>,
    /// Whether the partner's silence keeps the force from acting.
    pub(super) is_silent: bool,
}

/// What follows from it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Verdict {
    /// Nothing new.
    Same,
    /// The network is bad: the force softens.
    Soften(Badness),
    /// The network is good again: the force returns.
    Harden,
    /// It has been bad for too long.
    Pause(Badness),
}

/// Counts of the play-out at one look.
type Counts = [u64; 4];

/// Watches a network.
#[derive(Debug, Clone)]
pub(super) struct Watch {
    settings: Fallback,
    looks: [Option<Counts>; WINDOW],
    next: usize,
    look_at: LocalTime,
    /// The oldest motion in use since the last look, s.
    age: f64,
    bad_since: Option<(LocalTime, Badness)>,
    good_since: Option<LocalTime>,
    share: f64,
    moved: LocalTime,
}

impl Watch {
    pub(super) fn new(settings: Fallback) -> Self {
        Self {
            settings,
            looks: [None; WINDOW],
            next: 0,
            look_at: LocalTime(0),
            age: 0.0,
            bad_since: None,
            good_since: None,
            share: 1.0,
            moved: LocalTime(0),
        }
    }

    /// The coupling begins: what was before says nothing of now.
    pub(super) fn begin(&mut self, now: LocalTime) {
        *self = Self { moved: now, look_at: now + LOOK, ..Self::new(self.settings) };
    }

    /// The share of the force that acts.
    pub(super) fn share(&self) -> f64 {
        self.share
    }

    /// Judges a tick; `counts` is asked ten times per second.
    pub(super) fn judge(
        &mut self,
        now: LocalTime,
        seen: &Seen,
        counts: impl FnOnce() -> PlayoutReport,
    ) -> Verdict {
        let aim = if self.bad_since.is_some() { self.settings.softened } else { 1.0 };
        let step = SLOPE * (now - self.moved).seconds().clamp(0.0, LOOK.seconds());
        self.share = aim.clamp(self.share - step, self.share + step);
        self.moved = now;
        self.age = seen.age.map_or(self.age, |age| self.age.max(age));
        if now - seen.heard >= self.settings.silence {
            return Verdict::Pause(Badness::Silence);
        }
        if now < self.look_at {
            return Verdict::Same;
        }
        self.look_at = now + LOOK;
        let PlayoutReport { received, lost, ticks, held_ticks, .. } = counts();
        let shares = self.window([received, lost, ticks, held_ticks]);
        let age = std::mem::replace(&mut self.age, 0.0);
        let excess = self.excess(shares, age, seen.is_silent);
        self.conclude(now, excess)
    }

    /// The shares lost and held within the window.
    fn window(&mut self, counts: Counts) -> [f64; 2] {
        let oldest = self.looks.iter().cycle().skip(self.next).take(WINDOW).flatten().next().copied();
        if let Some(place) = self.looks.get_mut(self.next) {
            *place = Some(counts);
        }
        self.next = (self.next + 1) % WINDOW;
        // a few packets say little
        let is_enough = self.looks.iter().flatten().count() > WINDOW / 2;
        let Some(oldest) = oldest.filter(|_| is_enough) else { return [0.0; 2] };
        let [received, lost, ticks, held] = [0, 1, 2, 3].map(|at| {
            let [now, then] = [&counts, &oldest].map(|counts| counts.get(at).copied().unwrap_or(0));
            now.saturating_sub(then) as f64
        });
        [lost / (received + lost).max(1.0), held / ticks.max(1.0)]
    }

    /// How far the worst of all is beyond its limit, as a ratio, and what it is.
    fn excess(&self, [loss, held]: [f64; 2], age: f64, is_silent: bool) -> (f64, Badness) {
        let Fallback { loss: most_lost, held: most_held, age: oldest, .. } = self.settings;
        // a share of 1 is never exceeded
        let ratio = |value: f64, most: f64| if value > 0.0 && most < 1.0 { value / most } else { 0.0 };
        let all = [
            (if is_silent { 2.0 } else { 0.0 }, Badness::Silence),
            (ratio(loss, most_lost), Badness::Loss),
            (ratio(held, most_held), Badness::Held),
            (age / oldest, Badness::Age),
        ];
        all.into_iter().fold((0.0, Badness::Loss), |worst, one| if one.0 > worst.0 { one } else { worst })
    }

    fn conclude(&mut self, now: LocalTime, (ratio, badness): (f64, Badness)) -> Verdict {
        let is_aged = badness == Badness::Age;
        // an age does not fall by half before the network is what it was
        let is_good = ratio <= if is_aged { 1.0 } else { GOOD };
        match self.bad_since {
            None if ratio > 1.0 => {
                (self.bad_since, self.good_since) = (Some((now, badness)), None);
                Verdict::Soften(badness)
            }
            Some(_) if is_good => {
                let since = *self.good_since.get_or_insert(now);
                if now - since < self.settings.recovery {
                    return Verdict::Same;
                }
                self.bad_since = None;
                Verdict::Harden
            }
            Some((since, badness)) => {
                self.good_since = None;
                if now - since >= self.settings.patience { Verdict::Pause(badness) } else { Verdict::Same }
            }
            None => Verdict::Same,
        }
    }
}
