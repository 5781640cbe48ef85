//! Whether the two handles are where a coupling may begin: close to each other and at rest.

use telespring::session::{LocalTime, Motion, Span};

use super::{Happened, Log};

/// An alignment is lost beyond so many times the distance and the speed at which it is found.
const SLACK: f64 = 1.5;
/// The offset is said again once it has changed by so much, m …
const CHANGE: f64 = 0.005;
/// … and this long has passed.
const QUIET: Span = Span(1_000_000_000);

/// Whether the handles are aligned, with hysteresis.
#[derive(Debug, Clone)]
pub(super) struct Alignment {
    /// The largest distance, m, and speed, m/s.
    distance: f64,
    speed: f64,
    /// The robot that this side moves.
    side: u8,
    /// What was said last, and when.
    said: Option<(LocalTime, [f64; 2])>,
}

impl Alignment {
    pub(super) fn new(distance: f64, speed: f64, side: u8) -> Self {
        Self { distance, speed, side, said: None }
    }

    /// From the own handle to the partner's, m.
    pub(super) fn offset(own: Option<&Motion>, partner: Option<[f32; 2]>) -> Option<[f64; 2]> {
        let (own, there) = (own?.position, partner?.map(f64::from));
        let ([x, y], [u, v]) = (own, there);
        Some([u - x, v - y])
    }

    /// Whether the handles are aligned, by the speed of the own one, m/s, and the way to the partner's, m; `was`: they were at the
    /// last tick.
    pub(super) fn judge(&self, speed: Option<f64>, offset: Option<[f64; 2]>, was: bool) -> bool {
        let slack = if was { SLACK } else { 1.0 };
        let (Some(speed), Some([x, y])) = (speed, offset) else { return false };
        x.hypot(y) <= slack * self.distance && speed <= slack * self.speed
    }

    /// Says how far the handles are apart, if that is news: always as the way that robot 2 has to go, so that both sites say
    /// the same.
    pub(super) fn tell(&mut self, now: LocalTime, offset: Option<[f64; 2]>, log: &mut Log) {
        let Some([x, y]) = offset else { return };
        let way = if self.side == 2 { [x, y] } else { [-x, -y] };
        let is_news = self
            .said
            .is_none_or(|(then, [u, v])| now - then >= QUIET && (way[0] - u).hypot(way[1] - v) >= CHANGE);
        if is_news && x.hypot(y) > self.distance {
            self.said = Some((now, way));
            log.push(now, Happened::Offset(way));
        }
    }

    /// The next offset is news.
    pub(super) fn forget(&mut self) {
        self.said = None;
    }
}
