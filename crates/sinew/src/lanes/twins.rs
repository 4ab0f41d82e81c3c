//! Each operation of each instruction set against its scalar twin, on numbers of every kind.

use glam::Vec4;

use super::{Doubles, FIELDS, InstructionSet, LANES, Lanes, Record, Work, with};

const SETS: [InstructionSet; 2] = [InstructionSet::Simd128, InstructionSet::Avx2];

/// Numbers of every kind: both signs, zeros, the smallest, the largest, infinite.
const NUMBERS: [f32; 24] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    0.1,
    -0.3,
    3.0,
    1e-30,
    -1e-30,
    1e30,
    -1e30,
    1e-45,
    -1e-45,
    f32::MAX,
    f32::MIN,
    f32::MIN_POSITIVE,
    f32::INFINITY,
    f32::NEG_INFINITY,
    1.000_000_1,
    16_777_216.0,
    0.333_333_34,
    -7.25,
    123.456,
    2e-3,
];

/// All operations on one or two numbers of lanes.
struct Everything {
    a: [f32; LANES],
    b: [f32; LANES],
}

impl Work for Everything {
    type Output = Vec<[u32; LANES]>;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Self::Output {
        let (a, b) = (L::load(&self.a), L::load(&self.b));
        let mask = a.lt(b);
        let both = mask.or(a.same(b));
        let ((firsts, seconds), (these, next)) = (a.deinterleave(b), a.interleave(b));
        let bits = L::splat((a.le(b).bits() << 8 | mask.bits()) as f32);
        let any = L::splat(f32::from(u8::from(mask.any())));
        let all = [
            a + b,
            a - b,
            a * b,
            a / b,
            -a,
            a.abs(),
            a.abs().sqrt(),
            a.min(b),
            a.max(b),
            both.select(a, b),
            mask.and(a),
            a.fourths(),
            a.with_fourths(b),
            L::splat(a.largest(-1.0)),
            bits,
            any,
            b.lt(a).select(a, L::zero()),
            firsts,
            seconds,
            these,
            next,
            firsts.interleave(seconds).1,
        ];
        // Which NaN results depends on how the compiler arranges an expression; whether it is NaN does not.
        let number = |x: f32| if x.is_nan() { f32::NAN.to_bits() } else { x.to_bits() };
        all.into_iter().map(|lanes| lanes.array().map(number)).collect()
    }
}

#[test]
fn every_operation_gives_the_bits_of_its_scalar_twin() {
    for shift in 0..NUMBERS.len() {
        for other in 0..NUMBERS.len() {
            let pick = |from: usize| core::array::from_fn(|i| NUMBERS[(from + i) % NUMBERS.len()]);
            let work = || Everything { a: pick(shift), b: pick(other) };
            let truth = with(InstructionSet::Scalar, work());
            for set in SETS {
                assert_eq!(with(set, work()), truth, "{set:?} {:?} {:?}", work().a, work().b);
            }
        }
    }
}

/// Loads particles and records in every way, changes them, and stores them in every way.
struct Moves<'a> {
    packed: &'a mut [Vec4],
    records: &'a mut [Record],
    rows: [u32; LANES],
}

impl Work for Moves<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { packed, records, rows } = self;
        let [a, .., b] = L::records::<FIELDS>(records, &rows);
        let [c, d] = L::records(records, &rows);
        L::put_records(records, &rows, [b, [a[0] - a[3], d[3], c[1], c[2]]]);
        let [x, y, z, w] = L::rows(packed, &rows);
        L::put_rows(packed, &rows, [y, z + w, x, w]);
        let [x, y, z, w] = L::run(packed, 5);
        L::put_run(packed, 5, [x + y, y, w, z]);
        let ([x, y, z, w], other) = L::pairs(packed, 20);
        L::put_pairs(packed, 20, other, [x, y - z, z, w]);
        let [x, y, z, w] = L::run_by_parity(packed, 2);
        L::put_run_by_parity(packed, 2, [x, z, y - w, w]);
        let (mut low, mut high) = ([0.0; LANES / 2], [0.0; LANES / 2]);
        (x + y).store_halves(&mut low, &mut high);
        let turned = L::load_halves(&high, &low).array();
        (0..LANES).for_each(|i| packed[i + 11].z += turned[i]);
        let two = L::two(packed, 37);
        two.with_fourths(two.fourths() + two).put_two(packed, 37);
    }
}

/// Records of eight consecutive particles, wrapping around.
fn records_of(packed: &[Vec4]) -> [Record; 40] {
    core::array::from_fn(|i| Record(core::array::from_fn(|j| packed[(i + j) % packed.len()])))
}

#[test]
fn particles_go_in_and_out_of_lanes_the_same_way() {
    let start: Vec<Vec4> = (0..40)
        .map(|i| {
            let i = i as f32;
            Vec4::new(i, i + 100.0, i + 200.0, i + 300.0)
        })
        .collect();
    let moved = |set| {
        let (mut packed, mut records) = (start.clone(), records_of(&start));
        let rows = [3, 17, 0, 39, 8, 25, 12, 31];
        with(set, Moves { packed: &mut packed, records: &mut records, rows });
        (packed, records.map(|record| record.0))
    };
    let truth = moved(InstructionSet::Scalar);
    assert_eq!(truth.0[3], Vec4::new(103.0, 3.0, 506.0 - 303.0, 303.0));
    assert_eq!(truth.0[37].x, start[37].x);
    // The last field became the first, and the third did not change.
    assert_eq!([truth.1[17][0], truth.1[17][2]], [start[24], start[19]]);
    assert_eq!(truth.1[17][1], Vec4::new(17.0 - 317.0, 318.0, 117.0, 217.0));
    for set in SETS {
        assert_eq!(moved(set), truth, "{set:?}");
    }
}

#[test]
fn rows_that_do_not_exist_are_refused_by_every_set() {
    for set in InstructionSet::ALL {
        for row in [40, u32::MAX] {
            let refused = std::panic::catch_unwind(|| {
                let mut packed = vec![Vec4::ZERO; 40];
                let records = &mut records_of(&packed);
                let rows = [0, 1, 2, row, 4, 5, 6, 7];
                with(set, Moves { packed: &mut packed, records, rows });
            });
            assert!(refused.is_err(), "{set:?} {row}");
        }
    }
}

/// All operations on one or two numbers of lanes in double precision.
struct Doubled {
    a: [f32; LANES],
    b: [f32; LANES],
}

impl Work for Doubled {
    type Output = Vec<u64>;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Self::Output {
        let (a, b) = (L::load(&self.a).widen(), L::load(&self.b).widen());
        let sum = a + b * L::Doubles::splat(0.1);
        let mut all = Vec::new();
        let mut loaded = [0.0; LANES];
        (a * b).store(&mut loaded);
        for doubles in [sum, a - b, L::Doubles::load(&loaded), a / b, -sum] {
            let number = |x: f64| if x.is_nan() { f64::NAN.to_bits() } else { x.to_bits() };
            all.extend(doubles.array().map(number));
            let narrow = |x: f32| if x.is_nan() { f32::NAN.to_bits() } else { x.to_bits() };
            all.extend(L::narrow(doubles).array().map(|x| u64::from(narrow(x))));
            let bits = [doubles.lt(b), doubles.le(b), doubles.finite()];
            all.extend(bits.map(u64::from));
            all.extend(L::mask(bits[0]).and(L::splat(2.0)).array().map(|x| x as u64));
        }
        all
    }
}

#[test]
fn double_precision_has_the_bits_of_its_scalar_twin() {
    for shift in 0..NUMBERS.len() {
        for other in 0..NUMBERS.len() {
            let pick = |from: usize| core::array::from_fn(|i| NUMBERS[(from + i) % NUMBERS.len()]);
            let work = || Doubled { a: pick(shift), b: pick(other) };
            let truth = with(InstructionSet::Scalar, work());
            for set in SETS {
                assert_eq!(with(set, work()), truth, "{set:?} {:?} {:?}", work().a, work().b);
            }
        }
    }
    let sums = with(InstructionSet::best(), Doubled { a: [1.0; LANES], b: [1e-9; LANES] });
    assert_eq!(f64::from_bits(sums[0]), 1.0 + f64::from(1e-9_f32) * 0.1, "single would lose it");
}
