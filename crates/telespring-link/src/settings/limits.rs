//! `[limits]`: what the robot, and `[limits.person]` what the person, may be exposed to.

use serde::Deserialize;
use telespring::InvalidInput;

use crate::site::Limits;

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
pub(super) struct Text {
    force: Option<f64>,
    rise: Option<f64>,
    velocity: Option<f64>,
    #[serde(default)]
    workspace: Workspace,
    scale: Option<f64>,
    #[serde(default)]
    lock: Vec<Axis>,
    person: Option<Person>,
}

/// As [`Text`], for the person.
#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
struct Person {
    force: Option<f64>,
    rise: Option<f64>,
    velocity: Option<f64>,
    #[serde(default)]
    workspace: Workspace,
    scale: Option<f64>,
    #[serde(default)]
    lock: Vec<Axis>,
}

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

/// Limits that are those of `usual` where none is given: force, rise, velocity and scale.
fn limits(
    usual: Limits,
    [force, rise, velocity, scale]: [Option<f64>; 4],
    workspace: &Workspace,
    lock: &[Axis],
) -> Limits {
    let [x, y] = usual.workspace;
    Limits {
        force: force.unwrap_or(usual.force),
        rise: rise.unwrap_or(usual.rise),
        velocity: velocity.unwrap_or(usual.velocity),
        workspace: [workspace.x.unwrap_or(x), workspace.y.unwrap_or(y)],
        scale: scale.unwrap_or(usual.scale),
        lock: [lock.contains(&Axis::X), lock.contains(&Axis::Y)],
    }
}

/// The tighter of both.
pub(super) fn read(text: &Text) -> Result<Limits, InvalidInput> {
    let Text { force, rise, velocity, workspace, scale, lock, person } = text;
    let robot = limits(Limits::default(), [*force, *rise, *velocity, *scale], workspace, lock);
    robot.check()?;
    let Some(Person { force, rise, velocity, workspace, scale, lock }) = person else { return Ok(robot) };
    let person = limits(Limits::NONE, [*force, *rise, *velocity, *scale], workspace, lock);
    person.check().map_err(|mut refusal| {
        refusal.field = refusal.field.replace("limits.", "limits.person.");
        refusal
    })?;
    let both = robot.and(person);
    both.check()?;
    Ok(both)
}
