//! `[limits]`: what the robot, and `[limits.person]` what the person, may be exposed to.

use serde::Deserialize;
use telespring::InvalidInput;

use crate::site::Limits;

/// A table of limits: serde cannot both share keys and refuse unknown ones.
macro_rules! table {
    ($(#[$about:meta])* $name:ident $(, $more:ident: $kind:ty)?) => {
        $(#[$about])*
        #[derive(Deserialize, Default)]
        #[serde(deny_unknown_fields)]
        pub(super) struct $name {
            force: Option<f64>,
            rise: Option<f64>,
            velocity: Option<f64>,
            #[serde(default)]
            workspace: Workspace,
            scale: Option<f64>,
            #[serde(default)]
            lock: Vec<Axis>,
            $($more: $kind,)?
        }

        impl $name {
            /// The limits: those of `usual` where none is given.
            fn over(&self, usual: Limits) -> Limits {
                let [x, y] = usual.workspace;
                Limits {
                    force: self.force.unwrap_or(usual.force),
                    rise: self.rise.unwrap_or(usual.rise),
                    velocity: self.velocity.unwrap_or(usual.velocity),
                    workspace: [self.workspace.x.unwrap_or(x), self.workspace.y.unwrap_or(y)],
                    scale: self.scale.unwrap_or(usual.scale),
                    lock: [self.lock.contains(&Axis::X), self.lock.contains(&Axis::Y)],
                }
            }
        }
    };
}

table!(
    /// What the file says for the robot.
    Text, person: Option<Person>
);
table!(
    /// What it says for the person.
    Person
);

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
struct Workspace {
    x: Option<[f64; 2]>,
    y: Option<[f64; 2]>,
}

#[derive(Deserialize, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
enum Axis {
    X,
    Y,
}

/// The tighter of both.
pub(super) fn read(text: &Text) -> Result<Limits, InvalidInput> {
    let robot = text.over(Limits::default());
    robot.check()?;
    let Some(person) = &text.person else { return Ok(robot) };
    let person = person.over(Limits::NONE);
    person.check().map_err(|mut refusal| {
        refusal.field = refusal.field.replace("limits.", "limits.person.");
        refusal
    })?;
    let both = robot.and(person);
    both.check()?;
    Ok(both)
}
