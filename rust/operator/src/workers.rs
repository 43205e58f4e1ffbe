/// Ends a state of the vector registers in which worker threads run scalar code many times slower.
///
/// Parallel dense kernels may leave the upper halves of the vector registers in use when they return; on
/// some processors every scalar operation then waits for them (an exponential took 48 times as long
/// after a factorisation of 300 rows). A short norm on every worker ends with the instruction that
/// resets them. To be called after dense factorisations and solves that ran in parallel; costs some
/// microseconds.
pub fn reset_workers() {
    rayon::broadcast(|_| {
        let values = std::hint::black_box([1.0; 64]);
        std::hint::black_box(faer::ColRef::from_slice(&values).norm_l2());
    });
}
