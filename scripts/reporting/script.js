// SPDX-License-Identifier: GPL-3.0-or-later
for (const slider of document.querySelectorAll('.slider')) {
  const input = slider.querySelector('input');
  const move = () => slider.style.setProperty('--at', input.value + '%');
  input.addEventListener('input', move);
  move();  // browsers keep the value when a page is loaded again
}
addEventListener('beforeprint', () => document.querySelectorAll('details').forEach(block => { block.open = true; }));
