// Where the table, the spindle and what each joint carries are at joint positions: products of slides and turns, in the frame of the machine.
const kinematicsOf = (chains) => {
  'use strict';
  const { joints, tool_chain, work_chain, gauge, work } = chains;
  const radian = Math.PI / 180;
  const motion = (j, value) => {
    const { rotary, axis, point, shift } = joints[j];
    if (!rotary) return Poses.shift(axis.map((d) => d * value));
    const turn = Poses.aboutLine(point, axis, value * radian);
    if (shift) {
      const half = Math.sin(0.5 * value * radian), factor = -2 * half * half;
      for (let k = 0; k < 3; k++) turn[4 * k + 3] += factor * shift[k];
    }
    return turn;
  };
  return {
    // At positions in mm and degrees
    at(q) {
      const carried = joints.map(() => Poses.none);
      const end = (chain) => chain.reduce((pose, j) => carried[j] = Poses.times(pose, motion(j, q[j])), Poses.none);
      const spindle = Poses.times(end(tool_chain), gauge), table = end(work_chain);
      return { joints: carried, spindle, table, work: Poses.times(table, work) };
    },
  };
};
