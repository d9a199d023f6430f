//! On a golden file of the repository.
use vxs::{Filter, Kind, Level, State};

const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../tests/golden/blocks.vxs");

fn points() -> Vec<[f64; 3]> {
    let mut state = 7u64;
    let mut next = move || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 33) as f64 / (1u64 << 31) as f64 * 60.0 - 30.0
    };
    (0..3000).map(|_| [next(), next(), next()]).collect()
}

#[test]
fn many_are_as_one() {
    let (level, points) = (Level::open(FILE).unwrap(), points());
    let mut kinds = std::collections::BTreeSet::new();
    for light in level.lights() {
        for filter in [Filter::box_of(1), Filter::smooth(9)] {
            let mut lit = vec![0.0; points.len()];
            light.lookup_many(&points, None, filter, &mut lit);
            for (point, lit) in points.iter().zip(&lit) {
                assert_eq!(light.lookup(*point, None, filter).unwrap_or(-1.0), *lit);
                kinds.insert((lit * 2.0).ceil() as i32);
            }
        }
    }
    assert_eq!(kinds, [-2, 0, 1, 2].into());
}

#[test]
fn what_lights_are() {
    let level = Level::open(FILE).unwrap();
    assert_eq!(level.lights().len(), 4);
    let (sun, cube) = (level.lights().next().unwrap(), level.lights().last().unwrap());
    assert_eq!((sun.kind(), sun.map_count(), cube.map_count()), (Kind::Directional, 1, 6));
    assert_eq!(level.light(sun.name()).unwrap().words(), sun.words());
    assert!(level.light("none").is_none());
    let constants = sun.constants([0.0; 3], 12);
    assert_eq!((constants.first_word, constants.levels, std::mem::size_of_val(&constants)), (12, sun.resolution().trailing_zeros(), 96));
    let depths = cube.depth_map(5, 32).unwrap();
    assert!(depths.len() == 32 * 32 && depths.iter().any(|d| *d < 1.0));
    assert!(sun.depth_map(1, 32).is_err() && sun.depth_map(0, 100).is_err());
}

#[test]
fn intervals_have_the_state_of_their_points() {
    let (level, points) = (Level::open(FILE).unwrap(), points());
    for light in level.lights() {
        for pair in points.chunks(2).take(200) {
            let way = [0, 1, 2].map(|n| pair[1][n] - pair[0][n]);
            let parts = light.lit_intervals(pair[0], way, 0.0, 1.0).unwrap();
            assert!(parts[0].t_begin == 0.0 && parts.last().unwrap().t_end == 1.0);
            for part in parts.iter().filter(|p| p.t_end - p.t_begin > 1e-6) {
                let t = (part.t_begin + part.t_end) / 2.0;
                let wanted = [Some(1.0), Some(0.0), None][part.state as usize];
                assert_eq!(light.lookup([0, 1, 2].map(|n| pair[0][n] + t * way[n]), None, Filter::box_of(1)), wanted);
            }
        }
    }
    assert!(level.lights().next().unwrap().lit_intervals([f64::NAN; 3], [1.0; 3], 0.0, 1.0).is_err());
    assert_eq!(State::Lit as usize, 0);
}

#[test]
fn damaged_files_are_errors() {
    let bytes = std::fs::read(FILE).unwrap();
    assert_eq!(Level::from_bytes(&bytes[..40]).err().unwrap().finding, Some(101));
    assert_eq!(Level::from_bytes(b"glTF").err().unwrap().finding, Some(102));
    for n in 0..300 {
        let mut changed = bytes.clone();
        let at = (n * 7919) % bytes.len();
        changed[at] ^= 1 << (n % 8);
        assert!(Level::from_bytes(&changed).is_err(), "byte {at}");
    }
    assert!(Level::open("no such file").is_err());
}

#[test]
fn threads_share_a_level() {
    let level = std::sync::Arc::new(Level::open(FILE).unwrap());
    let sums: Vec<f32> = (0..4)
        .map(|_| {
            let level = level.clone();
            std::thread::spawn(move || points().iter().filter_map(|p| level.lights().next().unwrap().lookup(*p, None, Filter::box_of(9))).sum())
        })
        .map(|thread| thread.join().unwrap())
        .collect();
    assert!(sums.iter().all(|sum| sum == &sums[0] && *sum > 0.0));
}
