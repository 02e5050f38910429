//! Forward and inverse kinematics allocate nothing: counted by the allocator itself. One test alone in its
//! process, so that no other thread's allocations are counted.
#![allow(unsafe_code, reason = "counting allocations needs an allocator, and GlobalAlloc is an unsafe trait")]

use std::{
    alloc::{GlobalAlloc, Layout, System},
    hint::black_box,
    path::Path,
    sync::atomic::{AtomicUsize, Ordering},
};

use proveout_machine::{ConstantErrors, ErrorOf, JointValues, Machine, MotionState};

struct Counting;

static ALLOCATIONS: AtomicUsize = AtomicUsize::new(0);

// SAFETY: every call goes to the system's allocator unchanged; only a counter is added.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Ordering::Relaxed);
        // SAFETY: the caller keeps the contract of `alloc`, which is handed on.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the pointer came from `System` by way of `alloc` above.
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Ordering::Relaxed);
        // SAFETY: as `dealloc`.
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn allocations(work: impl FnOnce()) -> usize {
    let before = ALLOCATIONS.load(Ordering::SeqCst);
    work();
    ALLOCATIONS.load(Ordering::SeqCst) - before
}

#[test]
fn kinematics_allocate_nothing() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../machines/spinner-u5-620");
    let mut machine = Machine::read(&folder).expect("readable");
    // The counter counts: a stub that never moved would be caught here.
    assert_eq!(allocations(|| drop(black_box(Box::new(1)))), 1);
    let mut q = machine.home();
    for (value, set) in q.0.iter_mut().zip([12.0, -34.0, 450.0, 0.6, 2.1]) {
        *value = set;
    }
    for errors in [false, true] {
        if errors {
            let c = machine.joint("C").expect("C");
            machine.errors.constant = vec![ConstantErrors { of: ErrorOf::Joint(c), components: [1e-3; 6] }];
            machine = machine.recompiled();
        }
        let count = allocations(|| {
            for k in 0..100 {
                let mut q = q;
                q[4] += 0.01 * f64::from(k);
                let pose = black_box(machine.forward(black_box(&q), 100.0));
                let all = black_box(machine.inverse(&pose, 100.0));
                assert_eq!(all.len(), 2);
                black_box(machine.inverse_closest(&pose, 100.0));
                assert!(black_box(machine.inverse_nearest(&pose, 100.0, &q)).is_ok());
                black_box(machine.inverse_with_rotary(&pose.tip, &q, 100.0));
                black_box(machine.jacobian(&q, 100.0));
                black_box(machine.rotary_amplification(&q));
                black_box(machine.joint_poses(&q));
                black_box(machine.actual_forward(&q, 100.0));
                let state = MotionState { q, velocity: JointValues::ZERO, ..MotionState::default() };
                assert!(black_box(machine.limit_violations(&state, 0.0)).is_empty());
            }
        });
        assert_eq!(count, 0, "errors: {errors}");
    }
}
