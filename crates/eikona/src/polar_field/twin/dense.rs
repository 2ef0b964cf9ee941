//! Dense systems, by elimination.

use super::Form;

/// Groups of tied corners, each with the scale relative to the smallest of the group.
pub(super) fn tied(ties: &[([usize; 2], f64)], corners: usize) -> (Vec<usize>, Vec<f64>) {
    let (mut group, mut factor): (Vec<usize>, Vec<f64>) = ((0..corners).collect(), vec![1.0; corners]);
    for &([a, b], ratio) in ties {
        let (from, to) = (group[b], group[a]);
        let shift = ratio * factor[a] / factor[b];
        for c in (0..corners).filter(|&c| group[c] == from).collect::<Vec<_>>() {
            group[c] = to;
            factor[c] *= shift;
        }
    }
    let mut smallest = vec![f64::INFINITY; corners];
    (0..corners).for_each(|c| smallest[group[c]] = smallest[group[c]].min(factor[c]));
    (0..corners).for_each(|c| factor[c] /= smallest[group[c]]);
    (group, factor)
}

/// Minimises `(1 + z)' A (1 + z)` over `z >= 0` for the variables that are some group.
pub(super) fn nonnegative_minimum(matrix: &[Vec<f64>], group: &[usize]) -> Vec<f64> {
    let variables: Vec<usize> = (0..group.len()).filter(|&i| group[i] == i).collect();
    let mut above = vec![0.0; group.len()];
    let mut free: Vec<usize> = Vec::new();
    // The force upwards, relative to what it is the sum of.
    let pull = |above: &[f64], i: usize| -> f64 {
        let terms = variables.iter().map(|&j| -matrix[i][j] * (1.0 + above[j]));
        let size: f64 = terms.clone().map(f64::abs).sum();
        terms.sum::<f64>() / size
    };
    loop {
        let bound = variables.iter().filter(|i| !free.contains(i));
        let strongest = bound.copied().max_by(|&i, &j| pull(&above, i).total_cmp(&pull(&above, j)));
        match strongest {
            Some(i) if pull(&above, i) > 1e-12 => free.push(i),
            _ => break,
        }
        loop {
            let part = free.iter().map(|&i| free.iter().map(|&j| matrix[i][j]).collect()).collect::<Vec<_>>();
            let rhs: Vec<f64> =
                free.iter().map(|&i| -variables.iter().map(|&j| matrix[i][j]).sum::<f64>()).collect();
            let wanted = solved(&part, &rhs);
            // As far as the first variable that would become negative.
            let share = |(&i, &x): (&usize, &f64)| if x < 0.0 { above[i] / (above[i] - x) } else { 1.0 };
            let step = free.iter().zip(&wanted).map(share).fold(1.0, f64::min);
            free.iter().zip(&wanted).for_each(|(&i, x)| above[i] += step * (x - above[i]));
            if step == 1.0 {
                break;
            }
            free.retain(|&i| above[i] > 1e-14);
            variables.iter().filter(|i| !free.contains(i)).for_each(|&i| above[i] = 0.0);
        }
    }
    // The optimum of a convex problem: no force at free variables, none inwards at the others.
    for &i in &variables {
        let pull = pull(&above, i);
        assert!(if above[i] > 0.0 { pull.abs() < 1e-10 } else { pull < 1e-10 }, "{i}: {pull:e}");
    }
    above
}

/// Brings a matrix with a right-hand side to echelon form, and returns the columns of its pivots.
pub(super) fn eliminate(rows: &mut [Vec<f64>]) -> Vec<usize> {
    let mut pivots = Vec::new();
    for column in 0..rows.first().map_or(0, |row| row.len() - 1) {
        let r = pivots.len();
        let largest = |a: &usize, b: &usize| rows[*a][column].abs().total_cmp(&rows[*b][column].abs());
        let Some(pivot) = (r..rows.len()).max_by(largest) else { break };
        if rows[pivot][column].abs() < 1e-9 {
            continue;
        }
        rows.swap(r, pivot);
        let (above, below) = rows.split_at_mut(r + 1);
        for row in below.iter_mut().filter(|row| row[column] != 0.0) {
            let factor = row[column] / above[r][column];
            row.iter_mut().zip(&above[r]).skip(column).for_each(|(x, y)| *x -= factor * y);
        }
        pivots.push(column);
    }
    pivots
}

/// Solves a regular system, with a step of refinement.
pub(super) fn solved(matrix: &[Vec<f64>], rhs: &[f64]) -> Vec<f64> {
    let once = |rhs: &[f64]| {
        let mut rows: Vec<Vec<f64>> = matrix.to_vec();
        rows.iter_mut().zip(rhs).for_each(|(row, x)| row.push(*x));
        assert_eq!(eliminate(&mut rows).len(), rhs.len(), "the system is singular");
        let mut x = vec![0.0; rhs.len()];
        for i in (0..rhs.len()).rev() {
            let known: f64 = (i + 1..rhs.len()).map(|j| rows[i][j] * x[j]).sum();
            x[i] = (rows[i][rhs.len()] - known) / rows[i][i];
        }
        x
    };
    let mut x = once(rhs);
    let residual = |x: &[f64], i: usize| rhs[i] - matrix[i].iter().zip(x).map(|(a, b)| a * b).sum::<f64>();
    let missing: Vec<f64> = (0..rhs.len()).map(|i| residual(&x, i)).collect();
    x.iter_mut().zip(once(&missing)).for_each(|(x, y)| *x += y);
    x
}

pub(super) fn rank(forms: &[Form], columns: usize) -> usize {
    let dense = |form: &Form| {
        let mut row = vec![0.0; columns + 1];
        form.iter().for_each(|&(i, x)| row[i] += x);
        row
    };
    eliminate(&mut forms.iter().map(dense).collect::<Vec<_>>()).len()
}
