//! The same work on several items at once, one thread a core: results in the order of the items, whatever the number of cores.

/// `one` applied to each item.
pub(crate) fn parallel_map<I: Sync, T: Send>(items: &[I], one: impl Fn(&I) -> T + Sync) -> Vec<T> {
    let cores = std::thread::available_parallelism().map_or(1, |cores| cores.get()).min(items.len());
    if cores < 2 {
        return items.iter().map(one).collect();
    }
    let mut results: Vec<(usize, T)> = std::thread::scope(|scope| {
        let one = &one;
        let worker = |core: usize| {
            move || items.iter().enumerate().skip(core).step_by(cores).map(|(place, item)| (place, one(item))).collect::<Vec<_>>()
        };
        let workers: Vec<_> = (0..cores).map(|core| scope.spawn(worker(core))).collect();
        let joined = workers.into_iter().map(|worker| worker.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)));
        joined.flatten().collect()
    });
    results.sort_by_key(|(place, _)| *place);
    results.into_iter().map(|(_, result)| result).collect()
}

#[cfg(test)]
mod tests {
    use super::parallel_map;

    #[test]
    fn results_are_in_the_order_of_the_items() {
        for count in [0, 1, 7] {
            let items: Vec<u32> = (0..count).collect();
            assert_eq!(parallel_map(&items, |item| item * item), items.iter().map(|item| item * item).collect::<Vec<_>>());
        }
    }
}
