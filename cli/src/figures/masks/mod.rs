//! Fig. 8 to 11: from blockers to the lobes of their shadow, by the code that method `paper` runs.

mod lobes;
mod overlap;
mod setting;
mod square;
mod tree;

pub(super) use self::lobes::lobes;
pub(super) use self::overlap::overlap;
pub(super) use self::square::square;
pub(super) use self::tree::tree;
