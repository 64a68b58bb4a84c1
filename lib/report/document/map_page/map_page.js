// Draws the sheets of a map as surfaces that turn.
//
//   (u, v, w) : both coordinates and the value, each scaled to a box; w of values beyond the colours is that of the ends
//   screen    : x = u cos yaw − v sin yaw,  y = w cos pitch + d sin pitch,  d = u sin yaw + v cos yaw
//   depth     : d cos pitch − w sin pitch; faces are painted from far to near (painter's algorithm)
(()=>{
const $=id=>document.getElementById(id),data=JSON.parse($('data').textContent);
const {columns,grid,part,across,down,curves,shades,word}=data,n=grid.length;
const canvas=$('map'),pen=canvas.getContext('2d'),says=$('says'),choice=$('column');
const css=name=>getComputedStyle(document.documentElement).getPropertyValue(name);
const LIFT=.6,MARGIN=.25,SMOOTH=12000,TURN=Math.PI/36,OUTLIERS=.02,LONGEST=.2,JUMP=.25,BIAS=.02,DASH=6,REACH=14,LINE=15;
const parts=[...new Set(part)].filter(k=>k>0).sort((a,b)=>a-b),shown=new Set(parts);
const named=o=>o.name+(o.unit?' ('+o.unit+')':'');
const round=v=>v==null?'–':String(+v.toPrecision(4)).replace('-','−');
const axis=(a,index)=>'column' in a?columns[a.column].values:grid.map(g=>a.from+(a.to-a.from)*index(g)/a.steps);
const X=axis(data.x,g=>g%across),Y=axis(data.y,g=>Math.floor(g/across));
const extent=v=>{let a=Infinity,b=-Infinity;for(const x of v){if(x<a)a=x;if(x>b)b=x}return b>a?[a,b]:[a-.5,a+.5]};
let [xa,xb]=extent(X),[ya,yb]=extent(Y);
const flat=xb-xa,tall=yb-ya,equal='column' in data.x?Math.max(flat,tall):0;
const U=x=>(x-(xa+xb)/2)/(equal||flat),V=y=>(y-(ya+yb)/2)/(equal||tall);
const eu=U(xb),ev=V(yb);
const at=new Map(parts.map(k=>[k,new Int32Array(across*down).fill(-1)]));
for(let i=0;i<n;i++)if(part[i]>0)at.get(part[i])[grid[i]]=i;
// Quads of neighbouring grid points, triangles where one is missing.
function quadsOf(stride){
 const out=[];
 for(const k of parts){
  const cell=at.get(k),all=[];
  for(let j=0;j+1<down;j+=stride)for(let i=0;i+1<across;i+=stride){
   const r=Math.min(i+stride,across-1),t=Math.min(j+stride,down-1);
   const q=[cell[j*across+i],cell[j*across+r],cell[t*across+r],cell[t*across+i]].filter(c=>c>=0);
   const most=Math.max(LONGEST,3*stride/Math.min(across,down));
   if(q.length>2&&(!equal||q.every(c=>Math.abs(X[c]-X[q[0]])<=most*flat&&Math.abs(Y[c]-Y[q[0]])<=most*tall)))
    all.push(q)}
  out.push(all)}
 return out}
const fine=quadsOf(1),total=fine.reduce((s,q)=>s+q.length,0);
const coarse=total>SMOOTH?quadsOf(Math.ceil(Math.sqrt(total/SMOOTH))):fine;
let column=0,values,low,high,yaw=-.6,pitch=.55,zoom=1,mark=-1,drawn={},place=null,order=[],heights=[];
function choose(k){
 column=k;
 values=columns[k].values;
 const sorted=values.filter(v=>v!=null).sort((a,b)=>a-b),last=sorted.length-1;
 [low,high]=extent(last<0?[0,1]:[sorted[Math.floor(OUTLIERS*last)],sorted[Math.floor((1-OUTLIERS)*last)]]);
 $('low').textContent=round(low);
 $('high').textContent=round(high)+(columns[k].unit?' '+columns[k].unit:'');
 heights=curveValues();
 draw();
 tell()}
const share=v=>Math.max(0,Math.min(1,(v-low)/(high-low)));
const W=v=>(share(v)-.5)*LIFT;
// Value beside a point of a curve: 0 where it is singular, else the mean of the nearest cells of the sheets that meet there.
function valueBeside(r){
 const name=columns[column].name,kind=curves.kind[r],a=curves.cell[r],b=curves.other[r];
 if(kind===0&&name==='sigma.input'||kind===1&&(name==='sigma.output'||name==='manipulability'))return 0;
 const known=[a,b].filter(c=>c>=0&&values[c]!=null);
 return known.length?known.reduce((s,c)=>s+values[c],0)/known.length:null}
// Values on the curves: means of those beside the points that are near: within a step of
// the grid, or over a point within three, where neighbours of the grid are far apart.
function curveValues(){
 const beside=curves.x.map((_,r)=>valueBeside(r)),u=curves.x.map(U),v=curves.y.map(V),near=(equal?3:1)*Math.max(2*eu/across,2*ev/down);
 return beside.map((own,r)=>{
  let sum=own,count=1;
  for(const way of [-1,1])
   for(let k=r+way;curves.curve[k]===curves.curve[r]&&Math.hypot(u[k]-u[r],v[k]-v[r])<near;k+=way)
    if(beside[k]!=null){sum+=beside[k];count++}
  return own==null?null:sum/count})}
const isCurveShown=r=>[curves.cell[r],curves.other[r]].some(c=>c>=0&&shown.has(part[c]));
function size(){
 const ratio=devicePixelRatio||1,box=canvas.getBoundingClientRect();
 const w=Math.round(box.width*ratio),h=Math.round(box.height*ratio);
 if(canvas.width!==w||canvas.height!==h){canvas.width=w;canvas.height=h}
 pen.setTransform(ratio,0,0,ratio,0,0);
 return [box.width,box.height]}
function line(points){
 pen.beginPath();
 points.forEach(([x,y],i)=>i?pen.lineTo(x,y):pen.moveTo(x,y));
 pen.stroke()}
function steps(a,b,unit){
 const rough=(b-a)/5,ten=10**Math.floor(Math.log10(rough));
 const step=(unit==='deg'&&rough>10?[15,30,45,90,180,360]:[1,2,5,10].map(k=>k*ten)).find(s=>s>=rough)||360;
 const out=[];
 for(let k=Math.ceil(a/step-1e-9);k*step<=b+1e-9*step;k++)out.push(k*step);
 return out}
// Floor, ticks and names: at the edges nearest to the eye, the height at the leftmost one. Returns what writes the text,
// which is in front of the surfaces.
function axes(P,wide){
 const c=Math.cos(yaw),s=Math.sin(yaw),floor=-LIFT/2,front=c>0?-ev:ev,side=s>0?-eu:eu;
 const plain='13px "DejaVu Sans",Verdana,sans-serif',texts=[];
 let font=plain;
 pen.strokeStyle=css('--line');
 pen.lineWidth=1;
 const write=(text,x,y,align)=>texts.push([text,x,y,align,font]);
 const label=(text,u,v,w,du,dv,far)=>{
  const [x,y]=P(u,v,w),[x2,y2]=P(u+du,v+dv,w),l=Math.hypot(x2-x,y2-y)||1,dx=(x2-x)/l,dy=(y2-y)/l;
  write(text,x+dx*far,y+dy*far+(Math.abs(dy)>.3?Math.sign(dy)*4:0),dx<-.3?'right':dx>.3?'left':'center')};
 for(const x of steps(xa,xb,data.x.unit)){
  line([P(U(x),-ev,floor),P(U(x),ev,floor)]);
  label(round(x),U(x),front,floor,0,Math.sign(front),8)}
 for(const y of steps(ya,yb,data.y.unit)){
  line([P(-eu,V(y),floor),P(eu,V(y),floor)]);
  label(round(y),side,V(y),floor,Math.sign(side),0,8)}
 line([P(-eu,-ev,floor),P(eu,-ev,floor),P(eu,ev,floor),P(-eu,ev,floor),P(-eu,-ev,floor)]);
 const corners=[[-eu,-ev],[eu,-ev],[eu,ev],[-eu,ev]].sort((a,b)=>P(a[0],a[1],0)[0]-P(b[0],b[1],0)[0]),[u,v]=corners[0];
 const [x0]=P(u,v,0);
 line([P(u,v,floor),P(u,v,-floor)]);
 let last=Infinity;
 for(const t of steps(low,high,columns[column].unit)){
  const [x,y]=P(u,v,W(t));
  if(last-y<LINE)continue;
  last=y;
  line([[x,y],[x-4,y]]);
  write(round(t),x-7,y,'right')}
 font='bold '+plain;
 label(named(data.x),0,front,floor,0,Math.sign(front),34);
 label(named(data.y),side,0,floor,Math.sign(side),0,44);
 write(named(columns[column]),x0-40,P(u,v,-floor)[1]-16,'left');
 return ()=>{
  pen.fillStyle=css('--ink');
  pen.textBaseline='middle';
  for(const [text,x,y,align,style] of texts){ // none is cut off at a side of the picture
   pen.font=style;
   pen.textAlign=align;
   const width=pen.measureText(text).width,left=align==='left'?0:align==='right'?width:width/2;
   pen.fillText(text,Math.max(left+2,Math.min(wide-2-width+left,x)),y)}}}
function draw(quick){
 const [w,h]=size(),c=Math.cos(yaw),s=Math.sin(yaw),cp=Math.cos(pitch),sp=Math.sin(pitch),across=2*Math.hypot(eu,ev);
 const scale=zoom*Math.min(w/(across+MARGIN),h/(LIFT*cp+across*sp+MARGIN));
 const P=(u,v,z)=>[w/2+scale*(u*c-v*s),h*.5-scale*(z*cp+(u*s+v*c)*sp)],deep=(u,v,z)=>(u*s+v*c)*cp-z*sp;
 const px=new Float64Array(n),py=new Float64Array(n),depth=new Float64Array(n);
 for(let i=0;i<n;i++){
  const u=U(X[i]),v=V(Y[i]),z=values[i]==null?NaN:W(values[i]);
  [px[i],py[i]]=P(u,v,z);
  depth[i]=deep(u,v,z)}
 pen.clearRect(0,0,w,h);
 const writeTexts=axes(P,w);
 const items=[];
 (quick?coarse:fine).forEach((list,k)=>{
  if(shown.has(parts[k]))for(const q of list){
   let sum=0,mean=0;
   for(const i of q){sum+=depth[i];mean+=values[i]}
   if(sum===sum)items.push([sum/q.length,q,mean/q.length])}});
 const quads=items.length;
 let run=0,before=null;
 for(let r=0;r<curves.x.length;r++){
  const value=isCurveShown(r)?heights[r]:null,u=U(curves.x[r]),v=V(curves.y[r]);
  const now=value==null?null:{p:P(u,v,W(value)),d:deep(u,v,W(value)),x:curves.x[r],y:curves.y[r],curve:curves.curve[r]};
  if(now&&before&&before.curve===now.curve&&Math.abs(now.x-before.x)<JUMP*flat&&Math.abs(now.y-before.y)<JUMP*tall){
   const kind=curves.kind[r];
   run+=Math.hypot(now.p[0]-before.p[0],now.p[1]-before.p[1]);
   if(kind!==1||Math.floor(run/DASH)%3<2)items.push([(now.d+before.d)/2-BIAS,null,kind,before.p,now.p])}
  else run=0;
  before=now}
 items.sort((a,b)=>b[0]-a[0]);
 const inks=['#000','#cc1a1a','#666','#666'];
 pen.lineJoin='round';
 for(const [,q,v,a,b] of items){
  if(q){
   pen.beginPath();
   for(const i of q)pen.lineTo(px[i],py[i]);
   pen.closePath();
   pen.fillStyle=pen.strokeStyle=shades[Math.min(shades.length-1,Math.floor(share(v)*shades.length))];
   pen.lineWidth=.7;
   pen.fill();
   pen.stroke()}
  else{
   pen.strokeStyle='rgba(255,255,255,.8)';pen.lineWidth=4.5;pen.lineCap='butt';line([a,b]);
   pen.strokeStyle=inks[v];pen.lineWidth=2.2;pen.lineCap='round';line([a,b])}}
 pen.globalAlpha=.3; // lines behind surfaces are faint
 for(const [,q,v,a,b] of items)if(!q){pen.strokeStyle=inks[v];line([a,b])}
 pen.globalAlpha=1;
 writeTexts();
 order=items.filter(i=>i[1]);
 place=i=>[px[i],py[i]];
 drawn={quads,segments:items.length-quads};
 if(mark>=0&&shown.has(part[mark])&&values[mark]!=null){
  pen.strokeStyle=css('--ink');pen.lineWidth=1;pen.setLineDash([3,3]);
  line([P(U(X[mark]),V(Y[mark]),-LIFT/2),place(mark)]);
  pen.setLineDash([]);
  pen.beginPath();pen.arc(px[mark],py[mark],6,0,7);pen.fillStyle='#d55e00';pen.fill();
  pen.strokeStyle='#fff';pen.lineWidth=2;pen.stroke()}}
function tell(){
 const unit=o=>o.unit?' '+o.unit:'';
 const words=mark<0?'':`${data.x.name} ${round(X[mark])}${unit(data.x)} · ${data.y.name} ${round(Y[mark])}${unit(data.y)} · ${columns[column].name} ${round(values[mark])}${unit(columns[column])} · ${word} ${part[mark]}`;
 says.textContent=words||'Point at the surface, or press Shift with an arrow key, to read its values.';
 canvas.setAttribute('aria-label',`${columns[column].name} as height over ${data.x.name} and ${data.y.name}, ${shown.size} of ${parts.length} ${word}s. Arrow keys turn it, plus and minus zoom, Shift and arrow keys move the mark. ${words}`)}
let waiting=0;
const soon=quick=>{cancelAnimationFrame(waiting);waiting=requestAnimationFrame(()=>draw(quick))};
function turn(a,b){
 yaw+=a;
 pitch=Math.max(0,Math.min(Math.PI/2,pitch+b))}
const enlarge=by=>{zoom=Math.max(.4,Math.min(12,zoom*by))};
function marked(i){
 if(i===mark)return;
 mark=i;
 soon(false);
 tell()}
// The corner nearest to the pointer of the foremost quad under it.
function pick(e){
 const box=canvas.getBoundingClientRect(),x=e.clientX-box.left,y=e.clientY-box.top;
 const nearest=cells=>{let best=-1,least=Infinity;for(const i of cells){const [a,b]=place(i),d=Math.hypot(a-x,b-y);if(d<least){least=d;best=i}}return [best,least]};
 for(let k=order.length-1;k>=0;k--){
  const q=order[k][1];
  let inside=false;
  for(let i=0,j=q.length-1;i<q.length;j=i++){
   const [a,b]=place(q[i]),[c,d]=place(q[j]);
   if((b>y)!==(d>y)&&x<a+(c-a)*(y-b)/(d-b))inside=!inside}
  if(inside)return marked(nearest(q)[0])}
 const [i,far]=nearest(order.flatMap(o=>o[1]));
 if(far<REACH)marked(i)}
const fingers=new Map();
let apart=0,moved=0;
canvas.addEventListener('pointerdown',e=>{
 canvas.setPointerCapture(e.pointerId);
 fingers.set(e.pointerId,[e.clientX,e.clientY]);
 moved=apart=0});
canvas.addEventListener('pointermove',e=>{
 const from=fingers.get(e.pointerId);
 if(!from)return pick(e);
 const dx=e.clientX-from[0],dy=e.clientY-from[1];
 fingers.set(e.pointerId,[e.clientX,e.clientY]);
 moved+=Math.hypot(dx,dy);
 if(fingers.size>1){
  const [a,b]=[...fingers.values()],now=Math.hypot(a[0]-b[0],a[1]-b[1]);
  if(apart)enlarge(now/apart);
  apart=now}
 else turn(dx*.008,dy*.008);
 soon(true)});
for(const end of ['pointerup','pointercancel'])canvas.addEventListener(end,e=>{
 fingers.delete(e.pointerId);
 apart=0;
 soon(false);
 if(end==='pointerup'&&moved<4)pick(e)});
canvas.addEventListener('wheel',e=>{e.preventDefault();enlarge(Math.exp(-e.deltaY*.0015));soon(false)},{passive:false});
// The neighbour of the mark on its part of the grid.
function step(i,j){
 if(mark<0||!shown.has(part[mark]))return marked(order.length?order[order.length>>1][1][0]:-1);
 const g=grid[mark],a=g%across+i,b=Math.floor(g/across)+j,cell=a<0||b<0||a>=across||b>=down?-1:at.get(part[mark])[b*across+a];
 if(cell>=0)marked(cell)}
canvas.addEventListener('keydown',e=>{
 const by={ArrowLeft:[-1,0],ArrowRight:[1,0],ArrowUp:[0,1],ArrowDown:[0,-1]}[e.key];
 if(by&&e.shiftKey)step(by[0],by[1]);
 else if(by)turn(by[0]*TURN,by[1]*TURN);
 else if(e.key==='+'||e.key==='=')enlarge(1.2);
 else if(e.key==='-')enlarge(1/1.2);
 else if(e.key==='Home'){yaw=-.6;pitch=.55;zoom=1}
 else return;
 e.preventDefault();
 soon(false)});
columns.forEach((c,k)=>choice.add(new Option(named(c),k)));
choice.value=data.shown;
choice.addEventListener('change',()=>choose(+choice.value));
for(const k of parts){
 const label=document.createElement('label'),box=document.createElement('input');
 box.type='checkbox';
 box.checked=true;
 box.addEventListener('change',()=>{
  if(box.checked)shown.add(k);else shown.delete(k);
  draw();
  tell()});
 label.append(box,' '+word+' '+k);
 $('parts').append(label)}
$('scale').style.background=`linear-gradient(90deg,${shades.map((s,i)=>`${s} ${100*i/shades.length}% ${100*(i+1)/shades.length}%`)})`;
addEventListener('resize',()=>soon(false));
matchMedia('(prefers-color-scheme: dark)').addEventListener('change',()=>soon(false));
window.kmechMap={drawn:()=>drawn,place:i=>place(i),marked:()=>mark,view:()=>[yaw,pitch,zoom],draw};
choose(data.shown);
})();
