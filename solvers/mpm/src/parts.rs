//! Work on consecutive parts of a slice, on one thread or several, with the same result.

/// Parts above which work is shared out; one part is a block of particles or of nodes.
const SMALLEST: usize = 2;

/// Calls `f(part, its items, its output)` for each part. `ends` are the ends of the parts in `items`, rising.
pub(crate) fn for_parts<T: Send, U: Send>(
    parallel: bool,
    ends: &[usize],
    items: &mut [T],
    outputs: &mut [U],
    f: &(impl Fn(usize, &mut [T], &mut U) + Sync),
) {
    split(parallel, (0, 0), ends, items, outputs, f);
}

fn split<T: Send, U: Send>(
    parallel: bool,
    (part, start): (usize, usize),
    ends: &[usize],
    mut items: &mut [T],
    outputs: &mut [U],
    f: &(impl Fn(usize, &mut [T], &mut U) + Sync),
) {
    if parallel && ends.len() >= 2 * SMALLEST {
        let half = ends.len() / 2;
        let middle = ends[half - 1];
        let (items_a, items_b) = items.split_at_mut(middle - start);
        let (outputs_a, outputs_b) = outputs.split_at_mut(half);
        rayon::join(
            || split(true, (part, start), &ends[..half], items_a, outputs_a, f),
            || split(true, (part + half, middle), &ends[half..], items_b, outputs_b, f),
        );
        return;
    }
    let mut from = start;
    for (i, (&end, output)) in ends.iter().zip(outputs).enumerate() {
        let (head, tail) = items.split_at_mut(end - from);
        f(part + i, head, output);
        (items, from) = (tail, end);
    }
}
