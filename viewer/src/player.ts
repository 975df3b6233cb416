// The clock of the page: where in the motion we are, and how it goes on.

export const SPEEDS = [0.1, 0.25, 0.5, 1, 1.5, 2];

export class Player {
  time = 0;
  playing = false;
  speed = 1;
  loop = true;
  private last = 0;
  private readonly listeners: (() => void)[] = [];

  constructor(public duration: number) {}

  onChange(listener: () => void): void { this.listeners.push(listener); }

  changed(): void { this.listeners.forEach((listener) => listener()); }

  seek(time: number): void {
    this.time = Math.min(this.duration, Math.max(0, time));
    this.changed();
  }

  toggle(): void {
    if (!this.playing && this.time >= this.duration) this.time = 0;
    this.playing = !this.playing;
    this.last = performance.now();
    if (this.playing) requestAnimationFrame((now) => this.tick(now));
    this.changed();
  }

  pause(): void { if (this.playing) this.toggle(); }

  faster(steps: number): void {
    const at = SPEEDS.indexOf(this.speed) + steps;
    this.speed = SPEEDS[Math.min(SPEEDS.length - 1, Math.max(0, at))];
    this.changed();
  }

  private tick(now: number): void {
    if (!this.playing) return;
    // A page that was in the background goes on where it was.
    const passed = Math.min(0.1, Math.max(0, (now - this.last) / 1000));
    this.last = now;
    let time = this.time + passed * this.speed;
    if (time >= this.duration) {
      if (this.loop) time = 0; else { time = this.duration; this.playing = false; }
    }
    this.seek(time);
    requestAnimationFrame((next) => this.tick(next));
  }
}
