//! How far the account can be overdrawn, searched for with hands that know the device, and what a robot can make of it.

use crate::withstand_common::plant::AxisPlant;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use telespring::session::architecture::StrategyDesign;
use telespring::session::{AccountSettings, Architecture, EnergyAccount, Law, Overdraft, SideFacts};

/// A computing tick, and the lag in sample periods.
const DEVICES: [(bool, f64); 7] =
    [(false, 0.0), (true, 0.0), (false, 0.5), (false, 3.0), (false, 20.0), (true, 3.0), (true, 20.0)];
const PERIOD: f64 = 1e-3;
const MASS: f64 = 0.8;

fn settings(stiffness: f64, capacity: f64, (computing_tick, lag): (bool, f64)) -> AccountSettings {
    AccountSettings {
        capacity,
        computing_tick,
        sample_period: PERIOD,
        actuator_lag: lag * PERIOD,
        ..AccountSettings::new(stiffness, [0.0; 2])
    }
}

/// A device: what it does with a command, as the mean force of a period, N.
#[derive(Default)]
struct Device {
    pending: f64,
    force: f64,
}

impl Device {
    fn mean(&mut self, command: f64, (computing_tick, lag): (bool, f64)) -> f64 {
        let before = std::mem::replace(&mut self.pending, command);
        let command = if computing_tick { before } else { command };
        if lag == 0.0 {
            return command;
        }
        let rest = f64::exp(-1.0 / lag);
        let mean = command + (self.force - command) * lag * (1.0 - rest);
        self.force = command + (self.force - command) * rest;
        mean
    }
}

/// The deepest overdraft, J, of hands that load the account, rest, or move along with the force, at 1 m/s, and partners that
/// want everything and then, from some tick on, nothing.
fn deepest(stiffness: f64, device: (bool, f64), tries: usize, random: &mut ChaCha8Rng) -> f64 {
    let periods = 1.0 + f64::from(u8::from(device.0)) + device.1;
    let unit = 0.5 * stiffness * (PERIOD * periods).powi(2);
    let mut deepest = 0.0_f64;
    for _ in 0..tries {
        let capacity = unit * random.random_range(0.0..3.0);
        let mut account = EnergyAccount::new(settings(stiffness, capacity, device)).unwrap();
        let mut machine = Device::default();
        let loads =
            if random.random_bool(0.5) { random.random_range(0..(3.0 * periods) as usize + 4) } else { 0 };
        let starts = loads + random.random_range(0..(3.0 * periods) as usize + 4);
        let wants_until = starts + random.random_range(0..(2.0 * periods) as usize + 3);
        let sometimes: bool = random.random_bool(0.5);
        for tick in 0..starts + 60 + (8.0 * device.1) as usize {
            let wants = tick < wants_until && !(sometimes && random.random_bool(0.1));
            // a spring that is as long as its force: what the account holds beyond it is sent away
            let wanted = if wants { random.random_range(0.5..2.0) * account.largest_force() } else { 0.0 };
            let [command, _] = account.pay([wanted, 0.0], 0.0);
            let speed = match tick {
                _ if tick < loads => -1.0,
                _ if tick < starts => 0.0,
                _ => 1.0,
            };
            let mean = machine.mean(command, device);
            account.settle(PERIOD, [speed * PERIOD, 0.0], [mean, 0.0], 0.0);
            deepest = deepest.max(-account.balance());
        }
    }
    deepest
}

#[test]
fn law_no_hand_overdraws_the_account_by_more_than_the_ratio_of_its_kinetic_energy() {
    let mut random = ChaCha8Rng::seed_from_u64(12);
    for device in DEVICES {
        let stiffness = 10.0_f64.powf(random.random_range(1.0..3.7));
        let overdraft = settings(stiffness, 0.05, device).overdraft(MASS).unwrap();
        // at 1 m/s
        let found = deepest(stiffness, device, 4000, &mut random) / (0.5 * MASS) / overdraft.ratio;
        println!("computing tick {}, lag {}: {found:.4} of the bound", device.0, device.1);
        assert!(found <= 1.0 + 1e-9 && found > 0.999, "{device:?}: {found}");
    }
}

/// What a robot has made of the energy that was there at the start, in its motion and in the account: the largest kinetic
/// energy over it.
fn gain(settings: &AccountSettings, device: (bool, f64), moving: f64, wants_until: usize) -> f64 {
    let mut account = EnergyAccount::new(*settings).unwrap();
    let plain = AxisPlant::new(MASS, 0.0, 0.0, PERIOD);
    let lag = device.1 * PERIOD;
    let mut plant = if lag > 0.0 { plain.behind_lag(0.0, lag) } else { plain };
    plant.velocity = (2.0 * moving / MASS).sqrt();
    let (mut pending, mut largest) = (0.0, 0.0_f64);
    for tick in 0..wants_until + 10 + (5.0 * device.1) as usize {
        let wanted = if tick < wants_until { 1e6 } else { 0.0 };
        let [command, _] = account.pay([wanted, 0.0], 0.0);
        let before = std::mem::replace(&mut pending, command);
        let step = plant.advance_robot(if device.0 { before } else { command }, 0.0);
        account.settle(PERIOD, [step.moved, 0.0], [step.mean, 0.0], 0.0);
        largest = largest.max(plant.energy());
    }
    largest / (moving + settings.capacity)
}

/// Below the limit no robot has more than 1/(1 − ratio) of what was there, and hands that know the device come near it.
#[test]
fn law_a_robot_has_at_most_what_was_there_over_one_less_the_ratio() {
    let mut random = ChaCha8Rng::seed_from_u64(13);
    for device in DEVICES {
        let at_limit = settings(1.0, 0.05, device).overdraft(MASS).unwrap().proven_stiffness;
        let mut most = 0.0_f64;
        for _ in 0..3000 {
            let stiffness = at_limit * random.random_range(0.2..=1.0);
            let moving = 10.0_f64.powf(random.random_range(-4.0..1.0));
            let capacity = moving * 10.0_f64.powf(random.random_range(-3.0..0.5));
            let settings = settings(stiffness, capacity, device);
            let overdraft = settings.overdraft(MASS).unwrap();
            assert!(overdraft.is_proven());
            let gain = gain(&settings, device, moving, random.random_range(1..100));
            assert!(gain <= overdraft.largest_energy(1.0) * (1.0 + 1e-9), "{settings:?}: {gain}");
            most = most.max((gain - 1.0) / (overdraft.largest_energy(1.0) - 1.0));
        }
        println!("computing tick {}, lag {}: {most:.3} of the surplus", device.0, device.1);
        assert!(most > 0.95, "{device:?}: {most}");
    }
}

/// Against numbers worked out by hand.
#[test]
fn ref_the_ratio_is_that_of_the_proof() {
    let ratio = |stiffness, device| settings(stiffness, 0.05, device).overdraft(MASS).unwrap().ratio;
    let near =
        |value: f64, expected: f64| assert!((value / expected - 1.0).abs() < 1e-12, "{value} {expected}");
    near(ratio(800.0, (false, 0.0)), 1e-3);
    near(ratio(800.0, (true, 0.0)), 4e-3);
    near(ratio(800.0, (false, 9.0)), 0.1);
    near(ratio(200.0, (true, 18.0)), 0.1);
    // an encoder of 0.1 mm at 800 N/m: 4 k q² at rest
    let stepped = AccountSettings { encoder_step: 1e-4, ..settings(800.0, 0.05, (false, 0.0)) };
    let overdraft = stepped.overdraft(MASS).unwrap();
    near(overdraft.hidden, 4.0 * 800.0 * 1e-8);
    // E = available + (√(ratio E) + √hidden)²
    let energy = overdraft.largest_energy(0.3);
    near(energy, 0.3 + ((1e-3 * energy).sqrt() + overdraft.hidden.sqrt()).powi(2));
    near(Overdraft { hidden: 0.0, ..overdraft }.largest_energy(0.3), 0.3 / 0.999);
}

#[test]
fn law_a_live_side_refuses_what_the_account_does_not_bound_and_its_remedy_works() {
    let guard =
        Architecture { strategy: StrategyDesign::of_kind("guard").unwrap(), ..Architecture::default() };
    for (computing_tick, actuator_lag) in [(false, 0.0), (true, 0.0), (true, 0.02)] {
        let facts = |stiffness| SideFacts {
            session: 1,
            law: Law { stiffness, damping: 0.0 },
            delays: [0.05; 2],
            lateness: [0.0; 2],
            missing: [0.0; 2],
            has_playout_buffer: false,
            sample_period: 0.01,
            computing_tick,
            encoder_step: 0.0,
            actuator_lag,
            least_damping: [[7.7, 10.1]; 2],
            least_mass: [1.07, 0.8334],
        };
        let refusal = guard.endpoint_settings(&facts(20_000.0)).unwrap_err();
        assert_eq!((refusal.field.as_str(), refusal.value.as_str()), ("stiffness", "20000"), "{refusal}");
        println!("{refusal}");
        let remedy = refusal.to_string();
        let advised: f64 =
            remedy.split("Use at most ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
        let reaction = 0.01 + if computing_tick { 0.01 } else { 0.0 } + actuator_lag;
        assert!((advised - 0.1 * 0.8334 / (reaction * reaction)).abs() < 1e-3, "{advised}");
        assert!(guard.endpoint_settings(&facts(advised)).is_ok());
        // ten times as stiff the ratio is 1
        assert!(guard.endpoint_settings(&facts(9.999 * advised)).is_ok());
        assert!(guard.endpoint_settings(&facts(10.001 * advised)).is_err());
        // a rehearsal shows what happens then, and a bare spring has no account
        assert!(guard.rehearsal_settings(&facts(20_000.0)).is_ok());
        assert!(Architecture::default().endpoint_settings(&facts(20_000.0)).is_ok());
    }
}
